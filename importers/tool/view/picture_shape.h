// SPDX-License-Identifier: Apache-2.0
// In which proportions axes are drawn that are in different units. A degree has no length in metres: drawn as
// numbers, maps of a deep sea are a bundle of rods.
#pragma once

#include <array>
#include <optional>

#include "tool/handles.h"
#include "tool/view/render_arguments.h"

namespace bcc4 {

// Returns factors on the axes of the world and says so in a line; none: as stored.
[[nodiscard]] std::optional<std::array<double, 3>> picture_shape(const Volume& volume,
                                                                 const RenderArguments& arguments);

// The units of x, y and z where they are told to differ; none: they do not, or nobody knows.
[[nodiscard]] std::optional<std::array<std::string, 3>> different_units(const Volume& volume);

// sides: of the box in the world. Two axes of one unit keep their proportions, and the third has a part of
// their mean; where all differ each has its count of samples.
[[nodiscard]] std::array<double, 3> fair_shape(const std::array<double, 3>& sides,
                                               const std::array<std::string, 3>& units,
                                               const std::array<double, 3>& samples);

} // namespace bcc4
