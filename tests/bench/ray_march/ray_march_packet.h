// SPDX-License-Identifier: Apache-2.0
// What the vector body of the ray-marcher is given, in float.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "base/vec.h"

namespace bccsplat::bench {

inline constexpr int march_block = 32; // pixels per side: what one task draws

struct MarchLight {
  bool headlight = true;
  std::array<float, 3> direction{}, color{};
};

// A point in index space; the value there and the gradient, of trilinear interpolation twice the gradient.
using MarchPoint = std::array<float, 3>;
struct MarchFieldValue {
  float value = 0;
  std::array<float, 3> gradient{};
};

struct MarchPacketArgs {
  bool cubic = false; // MarchGrid
  const float* value = nullptr;
  int origin = 0, row = 0, plane = 0; // floats
  const uint8_t* distance = nullptr;  // per macro cell; null: no skipping
  Int3 cells{};
  std::array<float, 3> end{}; // the domain is [0, end]
  bool perspective = false;   // the view, as in SheetView
  std::array<float, 3> eye{}, ex{}, ey{}, ez{};
  float depth = 0, first_sheet = 0;
  int width = 0, height = 0;
  float* rgba = nullptr;
  size_t row_floats = 0;
  const float* table = nullptr; // ClassTable
  int entries = 0;
  float table_low = 0, table_scale = 0;
  bool isosurface = false, shading = true;
  float iso_value = 0, stop = 1;
  std::array<float, 3> iso_color{};
  int refinements = 6; // of a hit; the last one only places it
  float ambient = 0, diffuse = 0, specular = 0, shininess = 0, least_cosine = 0;
  int light_count = 0;
  std::array<MarchLight, 8> lights{};
};

} // namespace bccsplat::bench
