// SPDX-License-Identifier: Apache-2.0
// The time axis of a slab: an orthogonal change of basis, so that few layers hold what moves.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace bccsplat {

inline constexpr int basis_unit = 1 << 14;

// Rows of an orthogonal matrix, in 1 / basis_unit.
struct TimeBasis {
  int frames = 0;
  std::vector<int16_t> rows;
  // What a layer has of a frame, and a frame of a layer.
  [[nodiscard]] float weight(int layer, int frame) const {
    return static_cast<float>(rows[layer * frames + frame]) / basis_unit;
  }
};

// Cosines: for series that go on alike.
[[nodiscard]] TimeBasis cosine_basis(int frames);

// Frames to layers, in place. The way back is that of TileLayers (wavelet_tile.h). Rows are rounded, so that
// their transpose leads back to frames that are off by some 2^-13 of their values; exactly: by the inverse.
void to_layers(const TimeBasis& basis, std::span<float> slab, bool exactly);

} // namespace bccsplat
