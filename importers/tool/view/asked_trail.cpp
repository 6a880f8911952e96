// SPDX-License-Identifier: Apache-2.0
#include "tool/view/asked_trail.h"

#include <algorithm>

#include "tool/annotate/bars.h"
#include "tool/view/render_function.h"

namespace bcc4 {

AskedTrail::AskedTrail(const RenderArguments& a, const std::array<double, 2>& interval,
                       const std::vector<TransferFunction>& functions, bool of_other)
    : any_(interval[0] != 0 || interval[1] != 0), weights_(shutter_weights(a)) {
  trail_.content = a.trail_content;
  trail_.combine = a.trail_mode;
  trail_.intervals =
      of_other ? std::max<uint32_t>(1, static_cast<uint32_t>(weights_.size())) : trail_intervals(a);
  trail_.samples = a.trail_samples.value_or(0);
  trail_.unlit = a.trail_unlit ? 1 : 0;
  if (!weights_.empty()) {
    trail_.weights = weights_.data();
  } else if (trail_.intervals > 1 && functions.size() < 2) {
    colors_ = trail_colors(trail_.intervals);
    trail_.colors = colors_.data();
  }
  std::copy(interval.begin(), interval.end(), trail_.interval);
  functions_.reserve(functions.size());
  for (const TransferFunction& f : functions) functions_.push_back(as_struct(f));
  if (!functions_.empty())
    (functions_.size() > 1 ? trail_.transfer_functions : trail_.transfer_function) = functions_.data();
}

} // namespace bcc4
