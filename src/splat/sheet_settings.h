// SPDX-License-Identifier: Apache-2.0
// How the sheets of a shot are drawn: gradient, form of the kernel and raising, by its quality or as asked.
#pragma once

#include <optional>

#include "splat/plan/scene.h"

namespace bccsplat {

// What is asked of sheets whatever the quality says.
struct SheetWishes {
  std::optional<GradientMethod> gradient;
  std::optional<KernelForm> kernel_form;
  std::optional<RaiseFilter> raise;

  bool operator==(const SheetWishes&) const = default;
};

// Returns the options of the sheets of a shot, without pre-integration, which its points decide.
[[nodiscard]] SplatOptions sheet_options(const Shot& shot);

} // namespace bccsplat
