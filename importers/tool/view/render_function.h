// SPDX-License-Identifier: Apache-2.0
// The transfer functions that `bcc4 render` was asked for.
#pragma once

#include <optional>

#include "tool/handles.h"
#include "tool/view/render_arguments.h"
#include "tool/view/transfer_function.h"

namespace bcc4 {

// One object's share of the options.
struct FunctionChoice {
  std::string tf, colormap;
  std::optional<std::vector<double>> range;
  std::optional<double> opacity, unit_distance;
  int32_t look = BCCSPLAT_LOOK_DEFAULT;
  bool always = false; // even when nothing else asks for it
  bool opaque = false; // what is not air, as in a maximum
};
[[nodiscard]] FunctionChoice slice_function(const RenderArguments& arguments);
// Chooses the trail's functions: one for all its sub-intervals, one for each of them, or none, which is the
// slice's. What is not given is the slice's.
[[nodiscard]] std::vector<FunctionChoice> trail_functions(const RenderArguments& arguments);

// Colours and opacities; none: the library's own, which is `look` unchanged.
[[nodiscard]] std::optional<TransferFunction> transfer_function(const FunctionChoice& choice,
                                                                const bccsplat_channel_info& channel,
                                                                const bccsplat_look& look);
// The function of a trail that nobody chose one for; none: the slice's. Where there is no air all of the
// field would be in the trail of every moment: it has the part of the values that isosurfaces enclose.
[[nodiscard]] std::optional<TransferFunction> function_of_dense_trail(const FunctionChoice& slice,
                                                                      const bccsplat_look& look);
// The look that was chosen, for a mode of drawing.
[[nodiscard]] bccsplat_look make_look(const Volume& volume, uint32_t channel, int32_t look, int32_t mode);
// The same of a slice: off the time axis by its own values.
[[nodiscard]] bccsplat_look make_look(const Slice& slice, int32_t look, int32_t mode);
// Its points of value and linear colour.
[[nodiscard]] std::vector<std::array<double, 4>> colors_of(const bccsplat_look& look);
// Whether opacities are the look's, which are for what a frame is thick.
[[nodiscard]] bool by_look(const FunctionChoice& choice);
// The length that they are meant for in a slice; 0: a mean voxel. One through time, or one sample thick, is
// as opaque along its shortest axis as a frame is.
[[nodiscard]] double distance_of_look(const bccsplat_volume_info& volume, const bccsplat_slice_info& slice);
// Returns what of a channel's values is transparent, in words.
[[nodiscard]] std::string look_in_words(const bccsplat_look& look);
// The struct of the API; it borrows the function's points.
[[nodiscard]] bccsplat_transfer_function as_struct(const TransferFunction& function);

} // namespace bcc4
