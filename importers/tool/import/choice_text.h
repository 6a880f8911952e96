// SPDX-License-Identifier: Apache-2.0
// What was chosen for a series, and what it was chosen by, in lines of a report.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tool/import/plan_series.h"

namespace bcc4 {

// Lines with the key before each.
using ReportLines = std::vector<std::pair<std::string, std::string>>;
[[nodiscard]] ReportLines choice_lines(const ImportPlan& plan);

} // namespace bcc4
