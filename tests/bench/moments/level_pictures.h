// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "render/image.h"
#include "tests/bench/moments/moments_volume.h"
#include "tests/bench/report.h"

namespace bccsplat::bench {

// A moment in the middle of the series, 512 x 512, of level 0 at `best`.
[[nodiscard]] std::unique_ptr<ImageStorage> best_picture(const WrittenSeries& series,
                                                         const MomentOptions& options);

// The same moment from opening to picture, of each level, as a draft and as normal: time, bytes, memory, and
// the error against `truth`; and whether it is the level that such a picture is drawn of unasked.
void level_picture_rows(const Row& head, const WrittenSeries& series, const MomentOptions& options,
                        const Image& truth, std::vector<Row>& rows);

} // namespace bccsplat::bench
