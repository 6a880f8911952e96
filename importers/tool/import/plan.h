// SPDX-License-Identifier: Apache-2.0
// What import is about to do, in words and as JSON.
#pragma once

#include <string>

#include "choose/plan.h"
#include "tool/json_fwd.h"

namespace bcc4 {

[[nodiscard]] uint64_t cc_samples(const SeriesDescription& series); // all channels
// "0 to 98 s, 99 frames, step 1".
[[nodiscard]] std::string times_text(const SeriesTimes& times);

void print_plan(const ImportPlan& plan);
[[nodiscard]] Json plan_json(const ImportPlan& plan);

} // namespace bcc4
