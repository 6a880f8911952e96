// SPDX-License-Identifier: Apache-2.0
// Makes one file of the parts of a series.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/context.h"
#include "formats/bcc4/read/reader.h"
#include "store/write_report.h"

namespace bccsplat {

using SeriesParts = std::vector<std::shared_ptr<const Bcc4Reader>>;

// Opens parts in any order and returns them by rising frames. Throws invalid_argument, naming the files,
// unless they are the parts of one series and hold each of its frames once.
[[nodiscard]] SeriesParts open_parts(const std::vector<std::string>& paths);
[[nodiscard]] SeriesParts open_parts(std::vector<std::unique_ptr<ByteSource>> sources);

// Copies what the parts hold, in the order in which one writer of the whole series puts it: nothing is coded
// again. with_levels: coarser levels that no part has measured are compared with level 0
// (compared_levels.h). Throws bound_not_met when the series misses the PSNR that was asked for.
WriteReport join_parts(const SeriesParts& parts, const std::string& path, bool overwrite, bool with_levels,
                       const Context& context);
WriteReport join_parts(const SeriesParts& parts, std::unique_ptr<ByteSink> sink, bool with_levels,
                       const Context& context);

} // namespace bccsplat
