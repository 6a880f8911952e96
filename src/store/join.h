// SPDX-License-Identifier: Apache-2.0
// Makes one file of the parts of a series.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/context.h"
#include "formats/bcc4/write/joined_parts.h"
#include "store/write_report.h"

namespace bccsplat {

// The same of parts that are files; see joined_parts.h.
[[nodiscard]] SeriesParts open_parts(const std::vector<std::string>& paths);

// Copies what the parts hold, in the order in which one writer of the whole series puts it: nothing is coded
// again. with_levels: coarser levels that no part has measured are compared with level 0
// (compared_levels.h). Throws bound_not_met when the series misses the PSNR that was asked for.
WriteReport join_parts(const SeriesParts& parts, const std::string& path, bool overwrite, bool with_levels,
                       const Context& context);
WriteReport join_parts(const SeriesParts& parts, std::unique_ptr<ByteSink> sink, bool with_levels,
                       const Context& context);

} // namespace bccsplat
