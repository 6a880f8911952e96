// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "draw/image.h"
#include "scene/picture.h"
#include "scene/picture_needs.h"
#include "tests/bench/moments/moments_volume.h"
#include "tests/bench/report.h"

namespace bccsplat::bench {

// What gradients are lit as surfaces: those that are no noise of u8 (render/gradient_noise.h), or all.
enum class Lit : uint8_t { surfaces, everything };

inline constexpr int level_picture_size = 512;
[[nodiscard]] double moment_of(const MomentOptions& options); // the one that is drawn, frames

// Half transparent where values are high, and nothing below the middle of their range.
[[nodiscard]] TransferFunction function_of_codes();
// The slice as these pictures show it. `levels` must outlive it.
[[nodiscard]] Scene scene_of_codes(const Slice& slice, const CoarseLevels& levels, Lit lit);
// What is known of the levels of a volume for such a picture.
[[nodiscard]] std::vector<LevelOption> level_options(const Opened& volume, const Slice& slice);

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
