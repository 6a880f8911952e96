// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "tests/bench/moments/moments_volume.h"
#include "tests/bench/report.h"

namespace bccsplat::bench {

// A moment in the middle of the series from opening to picture, 512 x 512, of each level, as a draft and as
// normal: time, bytes, memory, and the error against the best picture of level 0; and whether it is the level
// that such a picture is drawn of unasked.
void level_picture_rows(const Row& head, const WrittenSeries& series, const MomentOptions& options,
                        std::vector<Row>& rows);

} // namespace bccsplat::bench
