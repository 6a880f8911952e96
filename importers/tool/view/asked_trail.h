// SPDX-License-Identifier: Apache-2.0
// A trail of --trail or --with as the C API takes it.
#pragma once

#include <array>
#include <vector>

#include "bccsplat.h"
#include "tool/view/render_arguments.h"
#include "tool/view/transfer_function.h"

namespace bcc4 {

class AskedTrail {
 public:
  // interval: in frames of the volume. functions: none: the slice's; one for all sub-intervals, or for each.
  // of_other: it belongs to the volume of --with, and has no sub-intervals but a shutter's.
  AskedTrail(const RenderArguments& arguments, const std::array<double, 2>& interval,
             const std::vector<TransferFunction>& functions, bool of_other = false);
  AskedTrail(const AskedTrail&) = delete;
  AskedTrail& operator=(const AskedTrail&) = delete;
  // NULL: there is none.
  [[nodiscard]] const bccsplat_trail* get() const { return any_ ? &trail_ : nullptr; }

 private:
  bool any_;
  std::vector<double> colors_, weights_;
  std::vector<bccsplat_transfer_function> functions_;
  bccsplat_trail trail_ = sized<bccsplat_trail>();
};

} // namespace bcc4
