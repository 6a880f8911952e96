// SPDX-License-Identifier: Apache-2.0
// What precedes the slabs of a trial file, and what follows from it.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "base/bytes.h"
#include "tests/bench/coder/context_walk.h"
#include "tests/bench/coder/details.h"
#include "tests/bench/coder/temporal.h"

namespace bccsplat::bench {

inline constexpr int edge_unit = 1 << (chunk_levels + 1); // that chunks are whole numbers of

struct TrialHead {
  std::array<int, 4> dims{};
  Chain chain;
  int slab = 0, edge = 0; // frames of a slab, samples of a chunk along each axis
  float mean = 0, low = 0, high = 0, step = 0;
  DetailRule rule;
  LevelWeights weights{};
  std::array<uint8_t, 2> centres{};
  [[nodiscard]] size_t frame() const { return chain.samples(); }
  [[nodiscard]] int slabs() const { return (dims[3] + slab - 1) / slab; }
  [[nodiscard]] int frames_of(int slab_index) const {
    const int first = slab_index * slab;
    return first + slab < dims[3] ? slab : dims[3] - first;
  }
};

void write_head(const TrialHead& head, ByteWriter& out);
// Throws corrupt, truncated.
[[nodiscard]] TrialHead read_head(ByteReader& in);

// The samples of a chunk in a slab of so many frames.
[[nodiscard]] DetailBox detail_box(const TrialHead& head, int frames, const std::array<int, 3>& position);
// Chunks of a slab, its coarse part among them.
[[nodiscard]] int chunks_of(const TrialHead& head);
// Calls body with the position of each chunk but the coarse part, x fastest.
template<class Body> void for_positions(const TrialHead& head, const Body& body) {
  const std::array<int, 3> n = chunk_counts(head.chain, head.edge);
  for (int z = 0; z < n[2]; ++z)
    for (int y = 0; y < n[1]; ++y)
      for (int x = 0; x < n[0]; ++x) body(std::array<int, 3>{x, y, z});
}
// Layers of a slab to its frames, in place.
void restore_frames(const TrialHead& head, const TimeBasis& basis, std::span<float> slab);

} // namespace bccsplat::bench
