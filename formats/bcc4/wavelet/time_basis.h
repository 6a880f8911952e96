// SPDX-License-Identifier: Apache-2.0
// The time axis of a slab: an orthogonal change of basis, so that few layers hold what moves.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace bccsplat {

// Rows of an orthogonal matrix, in 1 / basis_unit.
struct TimeBasis {
  int frames = 0;
  std::vector<int16_t> rows;
};
inline constexpr int basis_unit = 1 << 14;

// Cosines: for series that go on alike.
[[nodiscard]] TimeBasis cosine_basis(int frames);
// The principal components of the frames (each of `samples`, one after the other), the strongest first.
[[nodiscard]] TimeBasis principal_basis(std::span<const float> slab, int frames);

// The mean squares of the layers that frames make, from some of their samples.
[[nodiscard]] std::vector<double> variances_in(const TimeBasis& basis, std::span<const float> slab);

// Frames to layers, and back, in place.
void to_layers(const TimeBasis& basis, std::span<float> slab);
// filled: whether a layer has anything but 0.
void to_frames(const TimeBasis& basis, std::span<float> slab, const std::vector<bool>& filled);

} // namespace bccsplat
