// SPDX-License-Identifier: Apache-2.0
// The values of an isosurface, each with an opacity and a colour.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <span>

#include "base/vec.h"
#include "shade/class_table.h"

namespace bccsplat {

struct IsoSurface {
  double value = 0;
  double opacity = 1;
  std::optional<Vec3> color; // linear; none: the transfer function's at the value

  bool operator==(const IsoSurface&) const = default;
};

// Returns whether light passes any of the surfaces.
[[nodiscard]] inline bool sees_through(std::span<const IsoSurface> surfaces) {
  return std::any_of(surfaces.begin(), surfaces.end(), [](const IsoSurface& s) { return s.opacity < 1; });
}

// Returns the colour of a surface, and the extinction of its value.
[[nodiscard]] inline std::array<float, 4> surface_color(const IsoSurface& surface, const ClassTable& table) {
  std::array<float, 4> out = table.entry[table.index(static_cast<float>(surface.value))];
  if (surface.color)
    for (size_t c = 0; c < 3; ++c) out[c] = static_cast<float>((*surface.color)[c]);
  return out;
}

} // namespace bccsplat
