// SPDX-License-Identifier: Apache-2.0
// Reads the sites of a slice that one brick of the splatter covers, mirror images included, and holds the
// reference loops that sum them up and list their points (brick_sites_simd.cpp has the fast ones).
#include "splat/points/brick_sites.h"

#include <algorithm>
#include <cstring>

#include "splat/points/point_sizes.h"

namespace bccsplat {
namespace {

constexpr size_t rows = 8; // of sites, per coset and axis

} // namespace

SiteReader::SiteReader(const Slice& slice, const FoldedSites& sites) : slice_(slice) {
  constexpr size_t beyond = 16; // the last brick's planes are asked for, too
  for (size_t a = 0; a < 3; ++a) {
    for (const int32_t s : sites[a]) places_[a].push_back({s / brick_edge, s % brick_edge});
    places_[a].resize(sites[a].size() + beyond);
  }
}

void SiteReader::read(const Int3& origin, BrickSites& out) const {
  const bool bcc = slice_.lattice.bcc;
  const int step = bcc ? 2 : 1;
  for (size_t c = 0; c < (bcc ? 2u : 1u); ++c) {
    const BrickLayer& layer = slice_.coset[c];
    const auto place = [&](size_t a, size_t n) {
      return places_[a][(origin[a] + step * static_cast<int>(n)) + c];
    };
    std::array<Place, rows> x;
    for (size_t i = 0; i < rows; ++i) x[i] = place(0, i);
    // A stretch is a run of x whose sites lie side by side in one brick of the slice; others hold one site.
    struct Stretch {
      size_t to, count;
      Place from;
    };
    std::array<Stretch, rows> stretches;
    size_t number = 0;
    for (size_t i = 0; i < rows; ++i) {
      Stretch* const last = number ? &stretches[number - 1] : nullptr;
      if (last && x[i].brick >= 0 && x[i].brick == last->from.brick &&
          x[i].site == last->from.site + static_cast<int>(last->count))
        ++last->count;
      else
        stretches[number++] = {i, 1, x[i]};
    }
    for (size_t k = 0; k < rows; ++k)
      for (size_t j = 0; j < rows; ++j) {
        const Place y = place(1, j), z = place(2, k);
        float* const row = out.coefficient.data() + ((c * rows + k) * rows + j) * rows;
        for (size_t s = 0; s < number; ++s) {
          const auto& [to, count, from] = stretches[s];
          const Brick* const brick = from.brick < 0 || y.brick < 0 || z.brick < 0
                                         ? nullptr
                                         : layer.brick(from.brick, y.brick, z.brick);
          if (!brick) {
            std::fill_n(row + to, count, 0.0f);
            continue;
          }
          const float* const value =
              brick->value.data() + (z.site * brick_edge + y.site) * brick_edge + from.site;
          if (count == rows)
            std::memcpy(row, value, rows * sizeof(float));
          else
            for (size_t i = 0; i < count; ++i) row[to + i] = value[i];
        }
      }
  }
}

SiteOrder::SiteOrder(bool is_bcc) : bcc(is_bcc) {
  const int edge = bcc ? 16 : 8;
  for (int z = 0; z < edge; ++z)
    for (int y = 0; y < edge; ++y)
      for (int x = 0; x < edge; ++x)
        if (!bcc || ((x & 1) == (y & 1) && (x & 1) == (z & 1)))
          position.push_back(static_cast<uint16_t>(x | y << 4 | z << 8));
  uint32_t state = 0x9e3779b9u; // xorshift32: the same everywhere
  for (size_t n = position.size() - 1; n > 0; --n) {
    state ^= state << 13, state ^= state >> 17, state ^= state << 5;
    std::swap(position[n], position[state % (n + 1)]);
  }
  for (const uint16_t p : position) {
    const int x = p & 15, y = p >> 4 & 15, z = p >> 8 & 15;
    site.push_back(bcc ? (x & 1) << 9 | z >> 1 << 6 | y >> 1 << 3 | x >> 1 : z << 6 | y << 3 | x);
  }
}

namespace {

// Calls body(local planes x, y, z, coefficient) for every site of a brick.
template<class Body> void each_site(const BrickSites& sites, bool bcc, const Body& body) {
  for (size_t n = 0; n < (bcc ? 1024u : 512u); ++n) {
    const auto x = static_cast<int>(n & 7), y = static_cast<int>(n >> 3 & 7),
               z = static_cast<int>(n >> 6 & 7), c = static_cast<int>(n >> 9);
    if (bcc)
      body(2 * x + c, 2 * y + c, 2 * z + c, sites.coefficient[n]);
    else
      body(x, y, z, sites.coefficient[n]);
  }
}

} // namespace

void summarise_reference(const BrickSites& sites, bool bcc, SplatBrick& brick, BrickCells& cells) {
  brick.count = 0, brick.low.fill(255), brick.high.fill(0);
  std::array<bool, cells_per_brick> begun{};
  cells = {};
  each_site(sites, bcc, [&](int x, int y, int z, float c) {
    const size_t cell = x >> 2 | y >> 2 << 2 | z >> 2 << 4;
    cells.low[cell] = begun[cell] ? std::min(cells.low[cell], c) : c;
    cells.high[cell] = begun[cell] ? std::max(cells.high[cell], c) : c;
    begun[cell] = true;
    if (c == 0) return;
    ++brick.count;
    const std::array<int, 3> at{x, y, z};
    for (size_t a = 0; a < 3; ++a) {
      brick.low[a] = std::min(brick.low[a], static_cast<uint8_t>(at[a]));
      brick.high[a] = std::max(brick.high[a], static_cast<uint8_t>(at[a]));
    }
  });
  brick.coefficient[0] = std::min(0.0f, *std::min_element(cells.low.begin(), cells.low.end()));
  brick.coefficient[1] = std::max(0.0f, *std::max_element(cells.high.begin(), cells.high.end()));
}

void code_cells_reference(const BrickSites& sites, bool bcc, const SplatPoints& points, uint8_t* codes) {
  std::fill_n(codes, SplatPoints::fine_cells, uint8_t{0});
  each_site(sites, bcc, [&](int x, int y, int z, float c) {
    uint8_t& code = codes[fine_cell(static_cast<unsigned>(x | y << 4 | z << 8))];
    code = std::max(code, points.code(c));
  });
}

void list_points_reference(const BrickSites& sites, const SiteOrder& order, uint32_t count,
                           uint16_t* position, float* coefficient) {
  uint32_t n = 0;
  for (size_t s = 0; n < count; ++s) {
    const float c = sites.coefficient[order.site[s]];
    if (c == 0) continue;
    position[n] = order.position[s], coefficient[n] = c;
    ++n;
  }
}

} // namespace bccsplat
