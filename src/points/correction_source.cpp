// SPDX-License-Identifier: Apache-2.0
#include "points/correction_source.h"

namespace bccsplat {

CorrectionBricks::CorrectionBricks(const std::array<uint32_t, 4>& dims) {
  for (size_t a = 0; a < 3; ++a) {
    samples_[a] = dims[a];
    bricks_[a] = (samples_[a] + correction_edge - 1) / correction_edge;
  }
}

uint64_t CorrectionBricks::count() const { return bricks_[0] * bricks_[1] * bricks_[2]; }

Int3 CorrectionBricks::origin(uint32_t brick) const {
  const int64_t row = brick / bricks_[0];
  return {static_cast<int32_t>(brick % bricks_[0] * correction_edge),
          static_cast<int32_t>(row % bricks_[1] * correction_edge),
          static_cast<int32_t>(row / bricks_[1] * correction_edge)};
}

uint32_t CorrectionBricks::brick_of(const Int3& sample) const {
  constexpr int64_t edge = correction_edge;
  return static_cast<uint32_t>((sample[2] / edge * bricks_[1] + sample[1] / edge) * bricks_[0] +
                               sample[0] / edge);
}

} // namespace bccsplat
