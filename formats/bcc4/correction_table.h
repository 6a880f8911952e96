// SPDX-License-Identifier: Apache-2.0
// Corrections of a frame in bricks of 64^3 source samples, each with bounds: what looks at a part of a frame
// reads the bricks near it (bcc4.md, section 10).
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "formats/bcc4/coding/residuals.h"
#include "formats/bcc4/layout.h"
#include "points/correction_source.h"

namespace bccsplat {

// Returns the value of a correction, as every reader computes it.
[[nodiscard]] inline float correction_value(int64_t steps, double step) {
  return static_cast<float>(static_cast<double>(steps) * step);
}

// Returns a frame's list (rising voxels of the frame), or a part of it, brick by brick, with voxels of the
// brick. Throws Code::cancelled soon after a cancel.
[[nodiscard]] std::vector<std::pair<uint32_t, ResidualList>>
split_corrections(const CorrectionBricks& bricks, std::span<const ResidualSample> frame, Progress& progress);
// Returns the first voxel of a frame behind the plane of bricks that a voxel is in.
[[nodiscard]] uint64_t brick_plane_end(const CorrectionBricks& bricks, uint64_t voxel);
// Throws corrupt where the list of a brick has voxels beyond the frame, or values beyond the bounds.
void check_corrections(const CorrectionBricks& bricks, const CorrectionBrick& brick,
                       std::span<const ResidualSample> list, double step);

void write_correction_table(ByteWriter& out, std::span<const CorrectionBrick> table);
// Checks numbers, bounds and block references; file_bytes are those of the root. Throws corrupt, truncated.
inline constexpr uint64_t table_entry_bytes = 16 + block_ref_bytes; // of a brick in a table
[[nodiscard]] std::vector<CorrectionBrick> read_correction_table(std::span<const std::byte> decoded,
                                                                 const CorrectionBricks& bricks,
                                                                 uint64_t offset, uint64_t file_bytes);

} // namespace bccsplat
