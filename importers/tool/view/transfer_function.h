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
// Lets opacity rise from 0 near air, where fields ring, to a quarter at the farther end of [low, high], for
// colours that come without opacities.
void add_default_opacity(TransferFunction& function, double low, double high, double air);
void scale_opacity(TransferFunction& function, double factor);

} // namespace bcc4
