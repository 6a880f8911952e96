// SPDX-License-Identifier: Apache-2.0
// Bars of colours that are no function of a value: the surfaces of --iso, the times of a trail.
#pragma once

#include <optional>
#include <span>

#include "bccsplat.h"
#include "tool/annotate/color_bar.h"
#include "tool/handles.h"
#include "tool/view/render_arguments.h"
#include "tool/view/slice_choice.h"

namespace bcc4 {

// A field for each surface, lowest value below, with its opacity where light passes it. colors: of the
// transfer function.
[[nodiscard]] ColorBar surface_bar(const std::string& heading, std::vector<bccsplat_iso_surface> surfaces,
                                   const std::vector<std::array<double, 4>>& colors);

// A field for each label, lowest below. colors: of the look of labels, two points for each, from half way to
// the one before to half way to the next one.
[[nodiscard]] ColorBar label_bar(const std::string& heading,
                                 const std::vector<std::array<double, 4>>& colors);

// The colours that the sub-intervals of a trail have, the first one's first: blue over white to orange, three
// numbers each.
[[nodiscard]] std::vector<double> trail_colors(uint32_t intervals);

// When what is drawn in each colour was there, from the moment of the slice on. interval: as bccsplat_trail
// has it. None for trails of one colour and off the time axis.
[[nodiscard]] std::optional<ColorBar> trail_bar(const RenderArguments& arguments, const Volume& volume,
                                                const Cut& where, const std::array<double, 2>& interval);

} // namespace bcc4
