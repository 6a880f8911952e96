// SPDX-License-Identifier: Apache-2.0
// Keys of what is kept on the GPU.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "draw/shot.h"
#include "gpu/gpu_look.h"

namespace bccsplat {

// Tells a slice from any other one that may later stand at the same address.
struct SliceMark {
  const Slice* slice = nullptr;
  uint64_t bricks = 0; // of their places
  const void *corrections = nullptr, *mask = nullptr;
  double frame = 0, milliseconds = 0;
  std::array<double, 2> bounds{};
  bool operator==(const SliceMark&) const = default;
};
[[nodiscard]] SliceMark mark_of(const Slice& slice);
[[nodiscard]] SliceMark mark_without_bricks(const Slice& slice);

// What the classes of a picture are made of.
struct GpuClassKey {
  RenderMode mode = RenderMode::composite;
  std::vector<Vec4f> texels;
  float low = 0, scale = 0;
  std::vector<IsoSurface> surfaces;
  uint32_t disable_skips = 0;
  int cells_of_step = 0;
  float base = 0, air = 0;
  bool operator==(const GpuClassKey&) const = default;
};
[[nodiscard]] GpuClassKey key_of(const Shot& shot, const ClassTable& table, const std::vector<Vec4f>& texels);

} // namespace bccsplat
