// SPDX-License-Identifier: Apache-2.0
// Coefficients as whole steps from air (ValueType::i32), a chunk at a time.
//
// The steps of a chunk come in units of 2^shift, which the writer chooses here and the container finds again.
// Where neighbours predict a coefficient to within a fraction of a step, larger units would save nothing and
// be seen: constants and slow ramps keep shift 0. Elsewhere each doubling saves a bit per site. Rounding
// errors are shaped (noise_shape.h) where the shift is not 0.
#pragma once

#include <cstdint>
#include <span>

#include "formats/bcc4/coding/chunk.h"
#include "formats/bcc4/encode/noise_shape.h"
#include "points/brick.h"

namespace bccsplat {

struct CoefficientCoding {
  double step = 1;        // of shift 0
  int most_shift = 1;     // 0: one step for all
  NoiseShape shape{};     // all 0: errors stay where they are
  bool shape_all = false; // at shift 0, too
};

struct CoefficientChunk {
  ChunkSites sites; // ordered codes of i32
  int shift = 0;
};

// bricks: one per layer of the shape, null where all is air. Sites whose code is that of air are kept only as
// holes, or in gaps too short to pay.
[[nodiscard]] CoefficientChunk round_coefficients(const ChunkShape& shape,
                                                  std::span<const Brick* const> bricks,
                                                  const CoefficientCoding& coding);

// The chunk as it will be read again.
[[nodiscard]] ChunkData packed(const CoefficientChunk& chunk);

// The value of a code, relative to air.
[[nodiscard]] inline double coefficient_of(uint32_t code, const CoefficientCoding& coding) {
  return static_cast<int32_t>(code - i32_air) * coding.step;
}

} // namespace bccsplat
