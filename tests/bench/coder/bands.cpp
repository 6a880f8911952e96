// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/coder/bands.h"

#include <algorithm>

namespace bccsplat::bench {
namespace {

BandBox band_box(const Chain& chain, const std::array<int, 3>& position, int edge, int level, int direction) {
  BandBox box{level, direction, {}, {}};
  for (int a = 0; a < 3; ++a) {
    const bool fine = direction >> a & 1;
    const int scale = 1 << std::min(level, chain.halvings[a]), coarse = chain.kept(a, level),
              from = fine ? coarse : 0, count = fine ? chain.kept(a, level - 1) - coarse : coarse;
    const int begin = std::min(position[a] * edge / scale, count),
              end = std::min((position[a] + 1) * edge / scale, count);
    box.begin[a] = from + begin;
    box.size[a] = end - begin;
  }
  return box;
}

bool is_direction(const Chain& chain, int level, int direction) {
  for (int a = 0; a < 3; ++a)
    if ((direction >> a & 1) && !chain.halves(a, level)) return false;
  return true;
}

void add_level(const Chain& chain, const std::array<int, 3>& position, int edge, int level,
               std::vector<BandBox>& bands) {
  for (int direction = 1; direction < 8; ++direction)
    if (is_direction(chain, level, direction))
      bands.push_back(band_box(chain, position, edge, level, direction));
}

} // namespace

std::vector<BandBox> coarse_bands(const Chain& chain) {
  constexpr int everything = 1 << 20;
  std::vector<BandBox> bands{band_box(chain, {}, everything, chain.levels(), 0)};
  for (int level = chain.levels(); level > chunk_levels; --level)
    add_level(chain, {}, everything, level, bands);
  return bands;
}

std::vector<BandBox> chunk_bands(const Chain& chain, const std::array<int, 3>& position, int edge) {
  std::vector<BandBox> bands;
  for (int level = std::min(chain.levels(), chunk_levels); level >= 1; --level)
    add_level(chain, position, edge, level, bands);
  return bands;
}

std::array<int, 3> chunk_counts(const Chain& chain, int edge) {
  std::array<int, 3> counts{};
  for (int a = 0; a < 3; ++a) counts[a] = (chain.size[a] + edge - 1) / edge;
  return counts;
}

BandMagnitudes::BandMagnitudes(const BandBox& box, int layers)
    : width_(box.size[0] + 4), height_(box.size[1] + 4), depth_(box.size[2] + 4),
      values_(width_ * height_ * depth_ * (layers + 2) + 2 * width_) {}

} // namespace bccsplat::bench
