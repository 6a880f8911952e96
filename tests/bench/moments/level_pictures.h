// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "render/image.h"
#include "tests/bench/moments/moments_volume.h"
#include "tests/bench/report.h"

namespace bccsplat::bench {

// What gradients are lit as surfaces: those that are no noise of u8 (render/gradient_noise.h), or all.
enum class Lit : uint8_t { surfaces, everything };

// A moment in the middle of the series, 512 x 512, of level 0 at `best`.
[[nodiscard]] std::unique_ptr<ImageStorage>
best_picture(const WrittenSeries& series, const MomentOptions& options, Lit lit = Lit::surfaces);

// The same moment from opening to picture, of each level, as a draft and as normal: time, bytes, memory, and
// the error against `truth`; and whether it is the level that such a picture is drawn of unasked.
void level_picture_rows(const Row& head, const WrittenSeries& series, const MomentOptions& options,
                        const Image& truth, std::vector<Row>& rows);

// The same picture as a player of raw frames draws it: two frames in memory, blended, and rays through them
// (ray_march.h, whose grid is made beforehand). It lights everything, and so does its truth.
void raw_picture_rows(const Row& head, const MomentSeries& series, const MomentOptions& options,
                      const Image& truth, std::vector<Row>& rows);

} // namespace bccsplat::bench
