// SPDX-License-Identifier: Apache-2.0
#include "store/site_planes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace bccsplat {
void read_site_plane(const SampleLayer& layer, float air, int64_t z, float* to) {
  constexpr float none = std::numeric_limits<float>::quiet_NaN();
  const Int3 &n = layer.dims(), &bricks = layer.brick_dims();
  const int plane = static_cast<int>(z % brick_edge), bz = static_cast<int>(z / brick_edge);
  std::array<float, brick_rows + brick_edge> room;
  for (int by = 0; by < bricks[1]; ++by)
    for (int bx = 0; bx < bricks[0]; ++bx) {
      const SampleBrick& brick = layer.brick(bx, by, bz);
      const float* values = room.data();
      if (!brick)
        room.fill(0);
      else if (brick.values)
        values = brick.values->value.data() + plane * brick_rows;
      else
        brick.codes->read({.plane = plane}, room.data(), brick_edge);
      const BrickMask* const hole = brick.hole();
      const int width = std::min(brick_edge, n[0] - bx * brick_edge),
                height = std::min(brick_edge, n[1] - by * brick_edge);
      for (int y = 0; y < height; ++y) {
        const unsigned missing = hole ? (*hole)[size_t(plane) * brick_edge + y] : 0;
        float* const out = to + (int64_t{by} * brick_edge + y) * n[0] + int64_t{bx} * brick_edge;
        for (int x = 0; x < width; ++x) out[x] = missing >> x & 1 ? none : air + values[y * brick_edge + x];
      }
    }
}

float largest_at_sites(const SampleLayer& layer, float air, const Context& context) {
  std::vector<float> largest(layer.rows(), std::fabs(air));
  context.tasks.parallel_for(layer.rows(), [&](uint64_t row) {
    std::array<float, brick_sites> room;
    for (size_t slot = row * layer.row_slots(); slot < (row + 1) * layer.row_slots(); ++slot) {
      if (!layer.brick(slot)) continue;
      const float* const values = layer.brick(slot).all(room);
      const auto [low, high] = std::minmax_element(values, values + brick_sites);
      largest[row] = std::max({largest[row], std::fabs(air + *low), std::fabs(air + *high)});
    }
  });
  return *std::max_element(largest.begin(), largest.end());
}

} // namespace bccsplat
