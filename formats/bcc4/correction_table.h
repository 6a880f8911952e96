// SPDX-License-Identifier: Apache-2.0
// Corrections of a frame in bricks of 64^3 source samples, each with bounds: what looks at a part of a frame
// reads the bricks near it (bcc4.md, section 10).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "base/vec.h"
#include "formats/bcc4/coding/residuals.h"
#include "formats/bcc4/layout.h"

namespace bccsplat {

inline constexpr int32_t correction_edge = 64; // source samples

// An entry of the table.
struct CorrectionBrick {
  uint32_t brick = 0; // number, x fastest
  float low = 0, high = 0;
  uint32_t count = 0; // corrections in it
  BlockRef block;
};

// The bricks of a frame of n source samples.
class CorrectionBricks {
 public:
  explicit CorrectionBricks(const std::array<uint32_t, 4>& dims);
  [[nodiscard]] uint64_t count() const;
  [[nodiscard]] Int3 origin(uint32_t brick) const; // source sample
  [[nodiscard]] uint32_t brick_of(const Int3& sample) const;
  // The value of a correction, as every reader computes it.
  [[nodiscard]] static float value(int64_t steps, double step) {
    return static_cast<float>(static_cast<double>(steps) * step);
  }
  // Returns a frame's list (rising voxels of the frame), or a part of it, brick by brick, with voxels of the
  // brick. Throws Code::cancelled soon after a cancel.
  [[nodiscard]] std::vector<std::pair<uint32_t, ResidualList>> split(std::span<const ResidualSample> frame,
                                                                     Progress& progress) const;
  // Returns the first voxel of a frame behind the plane of bricks that a voxel is in.
  [[nodiscard]] uint64_t plane_end(uint64_t voxel) const;
  // Throws corrupt where the list of a brick has voxels beyond the frame, or values beyond the bounds.
  void check(const CorrectionBrick& brick, std::span<const ResidualSample> list, double step) const;

 private:
  std::array<int64_t, 3> samples_{}, bricks_{};
};

void write_correction_table(ByteWriter& out, std::span<const CorrectionBrick> table);
// Checks numbers, bounds and block references; file_bytes are those of the root. Throws corrupt, truncated.
[[nodiscard]] std::vector<CorrectionBrick> read_correction_table(std::span<const std::byte> decoded,
                                                                 const CorrectionBricks& bricks,
                                                                 uint64_t offset, uint64_t file_bytes);

} // namespace bccsplat
