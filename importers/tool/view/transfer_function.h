// SPDX-License-Identifier: Apache-2.0
// Transfer functions of the tool: built-in maps and ParaView's JSON colour maps.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "bccsplat.h"
#include "tool/view/color_space.h"

namespace bcc4 {

struct TransferFunction {
  std::vector<std::array<double, 4>> colors;    // value, linear RGB
  std::vector<std::array<double, 2>> opacities; // value, opacity per unit distance; empty: none given
  double unit_distance = 0;                     // world; 0: one mean voxel
};

[[nodiscard]] std::vector<std::string> colormap_names();
// A built-in map over [low, high].
[[nodiscard]] TransferFunction colormap(const std::string& name, double low, double high);

// The first map of a ParaView JSON file. RGBPoints are display colours; they are blended in
// the map's own space and made linear. `warning` gets what could not be honoured.
[[nodiscard]] TransferFunction read_paraview_json(const std::string& path, std::string& warning);
// Returns the function as one map of ColorSpace RGB that ParaView can import.
[[nodiscard]] std::string paraview_json(const TransferFunction& function, const std::string& name);

// Moves the values so that the colours (and opacities) span [low, high].
void rescale(TransferFunction& function, double low, double high);
// What is transparent unless somebody says otherwise: air, and the values that a look takes for air and noise
// (bccsplat_look.empty). opaque: all else is, as in a maximum.
struct Emptiness {
  double air = 0;
  std::array<double, 2> between{};
  bool opaque = false;
};
// Lets opacity rise from 0 near air, where fields ring, to a quarter at the farther end of [low, high], or at
// once to 1, for colours that come without opacities.
void add_default_opacity(TransferFunction& function, double low, double high, const Emptiness& empty);
void scale_opacity(TransferFunction& function, double factor);

} // namespace bcc4
