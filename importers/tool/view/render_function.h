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
  bool always = false; // even when nothing else asks for it
};
[[nodiscard]] FunctionChoice slice_function(const RenderArguments& arguments);
// What is not given for the trail is the slice's.
[[nodiscard]] FunctionChoice trail_function(const RenderArguments& arguments);

// Colours and opacities; none: the library's own.
[[nodiscard]] std::optional<TransferFunction> transfer_function(const FunctionChoice& choice,
                                                                const bccsplat_channel_info& channel);
// The struct of the API; it borrows the function's points.
[[nodiscard]] bccsplat_transfer_function as_struct(const TransferFunction& function);

} // namespace bcc4
