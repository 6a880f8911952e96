// SPDX-License-Identifier: Apache-2.0
// The files a series comes from, as a .bcc4 records them.
#pragma once

#include <span>
#include <vector>

#include "readers/frame_reader.h"
#include "tool/import/plan_file.h"

namespace bcc4 {

// Returns the files, with CRC-32 unless they are very many bytes. A file that is `known` by its name and size
// is not read: its CRC-32 is taken from there.
[[nodiscard]] std::vector<PlannedSource> sources_of(const SeriesDescription& series,
                                                    std::span<const PlannedSource> known = {});

} // namespace bcc4
