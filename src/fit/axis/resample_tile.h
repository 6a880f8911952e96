// SPDX-License-Identifier: Apache-2.0
// The inner loops of spatial resampling: z, then y, then x, on rows that stay in cache.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace bccsplat {

// Taps of the sites of a tile along y or z: site i is the sum over k of weight[i * taps + k] * row[i * taps +
// k], rows counted from the first one of the tile.
struct TileTaps {
  int taps = 0, count = 0;
  const float* weight = nullptr;
  const int32_t* row = nullptr;
};

// Sixteen sites along x: site i is the sum over k of weight[k * 16 + i] * in[base + index[i] + k].
struct TileBrickX {
  const float* weight = nullptr;  // 16 * taps
  const int32_t* index = nullptr; // 16, rising from 0
  int64_t base = 0;               // counted from the first sample of the extended row
  float* out = nullptr;           // a brick: (z * 16 + y) * 16 + x
};

// Sixteen sites along x again: bit i of `out` is set when row[base + index[i]] is not 0.
struct TileNearestX {
  const int32_t* index = nullptr; // 16, rising from 0
  int64_t base = 0;
  uint16_t* out = nullptr;
};

// A row of source samples begin .. end - 1 along x whose parts outside 0 .. n-1 are mirror images, or those
// at the other end of a periodic axis.
struct TileRow {
  int64_t begin = 0, end = 0;             // extended
  int64_t inner_begin = 0, inner_end = 0; // the samples that are read
  int64_t n = 0;
  bool turns = false;
};

// Rows are `pitch` floats, a multiple of 16; what lies beyond their samples does not matter.
// rows: the z rows of one y. out: z.count rows.
void tile_pass_z(const float* rows, size_t pitch, const TileTaps& z, float* out);
// `row` has 32 readable floats after the last one looked at.
void tile_nearest(const float* row, std::span<const TileNearestX> bricks);
// in: for each y, `z_count` rows. extended: space for end - begin + pitch + 64 floats. `pivot` is added to
// every site.
void tile_pass_yx(const float* in, size_t pitch, int z_count, const TileTaps& y, const TileRow& row,
                  int x_taps, std::span<const TileBrickX> bricks, float pivot, float* extended);

} // namespace bccsplat
