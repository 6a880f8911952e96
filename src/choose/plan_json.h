// SPDX-License-Identifier: Apache-2.0
// What was chosen for a series, and what it was chosen by, as JSON with stable keys.
#pragma once

#include <string>

#include "choose/plan.h"

namespace bccsplat::series {

[[nodiscard]] std::string json_of_plan(const ImportPlan& plan);

} // namespace bccsplat::series
