// SPDX-License-Identifier: Apache-2.0
// Codes a tile: the codes of its bricks are collected in boxes, one for each coset. Run lists go through the
// bricks one after the other.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <memory>
#include <utility>

#include "base/bytes.h"
#include "formats/bcc4/coding/chunk_parts.h"
#include "formats/bcc4/coding/layer_codes.h"
#include "formats/bcc4/coding/linear_tile.h"
#include "formats/bcc4/coding/open_tile.h"
#include "formats/bcc4/coding/tile_rows.h"
#include "formats/bcc4/encode/choose_tile.h"
#include "formats/bcc4/encode/encode_tile.h"
#include "points/rounded_brick.h"

namespace bccsplat {
namespace {

constexpr int block_edge = 4, blocks = brick_edge / block_edge; // of a block of air; along a brick
constexpr unsigned block_bits = 15;

std::vector<std::byte> tile_runs(const TileSites& sites) {
  ByteWriter out;
  RunEncoder occupancy(out);
  for (const ChunkSites& b : sites.bricks)
    for_rows(b.shape, [&](size_t m, size_t r, int width) { occupancy.row(b.kept[m][r], width); });
  occupancy.finish();
  const auto has_holes = [](const ChunkSites& b) { return !b.hole.empty(); };
  if (std::none_of(sites.bricks.begin(), sites.bricks.end(), has_holes)) return out.release();
  RunEncoder holes(out);
  for (const ChunkSites& b : sites.bricks)
    for_rows(b.shape, [&](size_t m, size_t r, int) {
      const uint16_t kept = b.kept[m][r], hole = b.hole.empty() ? uint16_t{0} : b.hole[m][r];
      holes.row(compress_bits(hole, kept), std::popcount(kept));
    });
  holes.finish();
  return out.release();
}

// The smallest and the largest of all codes.
CodeRange range_of_tile(const TileSites& sites) {
  CodeRange range{UINT32_MAX, 0};
  for (const ChunkSites& b : sites.bricks)
    for (const uint32_t c : b.codes) range = {std::min(range[0], c), std::max(range[1], c)};
  return range;
}

// Compares the codes that a reader gets of a layer of a brick with those that were wanted, one after the
// other.
template<class Code>
void compare(std::span<const std::byte> got, const uint32_t*& wanted, CodeRange& range, EncodedTile& tile) {
  for (size_t i = 0; i < got.size(); i += sizeof(Code)) {
    Code code;
    std::memcpy(&code, got.data() + i, sizeof code);
    const double off = static_cast<double>(code) - *wanted++;
    tile.squared_error += off * off;
    range = {std::min<uint32_t>(range[0], code), std::max<uint32_t>(range[1], code)};
  }
}

// Makes what a reader gets of the kept sites, within the range that they had; returns the range of that.
CodeRange read_back(const TileSites& sites, const SampleCoder& coder, std::vector<TileLayers> layers,
                    EncodedTile& tile) {
  const OpenTile back(sites, coder.codes(), range_of_tile(sites), std::move(layers));
  CodeRange range{UINT32_MAX, 0};
  tile.bricks.resize(size_t(sites.place.bricks()) * sites.place.layers);
  for (int i = 0; i < sites.place.bricks(); ++i) {
    const ChunkData& brick = back.bricks()[i];
    const uint32_t* next = sites.bricks[i].codes.data();
    for (int m = 0; m < sites.place.layers; ++m) {
      if (brick.first[m + 1] == brick.first[m]) continue;
      auto codes = std::make_shared<const LayerCodes>(coder, back, i, m);
      if (coder.codes().bytes() == 1)
        compare<uint8_t>(codes->packed(), next, range, tile);
      else
        compare<uint16_t>(codes->packed(), next, range, tile);
      tile.bricks[size_t(i) * sites.place.layers + m].codes = std::move(codes);
    }
  }
  return range;
}

// Samples as a reader gets them, but for a rounding that is next to nothing beside a code.
SampleBrick as_read(Brick&& brick, const SampleCoder& coder) {
  constexpr double of_code = as_read_rounding;
  const float coarsest = std::exp2(std::floor(std::log2(static_cast<float>(of_code * coder.scale()))));
  if (auto rounded = RoundedBrick::round(brick, coarsest)) return {nullptr, std::move(rounded)};
  return {std::make_shared<const Brick>(std::move(brick)), nullptr};
}

// The same of samples that are linear in what is coded.
CodeRange read_linear(const TileSites& sites, const SampleCoder& coder, const LinearTile& back,
                      EncodedTile& tile) {
  const auto scale = static_cast<float>(coder.scale()), air = coder.decode(coder.codes().air),
             air_code = static_cast<float>(coder.codes().air);
  const int layers = sites.place.layers;
  LinearRange range;
  tile.bricks.resize(size_t(sites.place.bricks()) * layers);
  std::vector<const uint32_t*> next;
  for (const ChunkSites& b : sites.bricks) next.push_back(b.codes.data());
  std::vector<float> box;
  for (int m = 0; m < layers; ++m) {
    back.make_layer(m, box);
    for (int i = 0; i < sites.place.bricks(); ++i) {
      if (back.kept(i, m) == BrickMask{}) continue;
      Brick brick{};
      brick.kept = back.kept(i, m);
      if (back.hole(i, m) != BrickMask{}) brick.hole = std::make_unique<BrickMask>(back.hole(i, m));
      for_kept(back, i, m, box, [&](size_t site, float sample) {
        const double off = static_cast<double>(sample + air_code) - *next[i]++;
        tile.squared_error += off * off;
        range.add(sample);
        brick.value[site] = scale * sample + air;
      });
      tile.bricks[size_t(i) * layers + m] = as_read(std::move(brick), coder);
    }
  }
  return range.nearest(coder.codes());
}

} // namespace

uint64_t TileSites::kept() const {
  uint64_t n = 0;
  for (const ChunkSites& b : bricks) n += b.codes.size();
  return n;
}

void keep_but_blocks_of_air(ChunkSites& sites, uint32_t air) {
  if (sites.codes.empty()) return;
  // A bit for each block along x of a row of blocks, by coset.
  std::array<std::array<uint8_t, blocks * blocks>, 2> filled{};
  const auto row_of = [](size_t r) {
    return r / brick_edge / block_edge * blocks + r % brick_edge / block_edge;
  };
  for_rows(sites.shape, [&](size_t m, size_t r, int) {
    for (int b = 0; b < blocks; ++b)
      if (sites.kept[m][r] >> (b * block_edge) & block_bits)
        filled[m % sites.shape.period][row_of(r)] |= static_cast<uint8_t>(1 << b);
  });
  std::vector<uint32_t> codes;
  const uint32_t* next = sites.codes.data();
  for_rows(sites.shape, [&](size_t m, size_t r, int width) {
    unsigned kept = 0;
    for (int b = 0; b < blocks; ++b)
      if (filled[m % sites.shape.period][row_of(r)] >> b & 1) kept |= block_bits << (b * block_edge);
    kept &= (1u << width) - 1;
    for (int x = 0; x < width; ++x)
      if (kept >> x & 1) codes.push_back(sites.kept[m][r] >> x & 1 ? *next++ : air);
    sites.kept[m][r] = static_cast<uint16_t>(kept);
  });
  sites.codes = std::move(codes);
}

std::array<std::vector<float>, 2> tile_values(const TileSites& sites, const ChunkCodes& codes) {
  std::array<std::vector<float>, 2> out;
  const auto boxes = sites.place.boxes();
  for (size_t c = 0; c < 2; ++c) out[c].resize(boxes[c].sites());
  for (int i = 0; i < sites.place.bricks(); ++i) {
    const ChunkSites& b = sites.bricks[i];
    const uint32_t* next = b.codes.data();
    for_tile_rows(sites.place, i, b.shape, [&](int m, int row, int width, int coset, size_t first) {
      for (int x = 0; x < width; ++x)
        if (b.kept[m][row] >> x & 1)
          out[coset][first + x] =
              static_cast<float>(static_cast<int32_t>(*next++) - static_cast<int32_t>(codes.air));
    });
  }
  return out;
}

EncodedTile encode_tile(const TileSites& sites, const SampleCoder& coder, const TileRule& asked, int level,
                        bool linear, TileRoom& room) {
  const auto boxes = sites.place.boxes();
  std::array<std::vector<float>, 2> values = tile_values(sites, coder.codes());
  std::array<TileBands, 2> bands;
  for (size_t c = 0; c < 2; ++c)
    bands[c] = analyse_tile(boxes[c], std::move(values[c]), asked.steps.step, asked.halvings_along_z);
  TileRule rule = asked;
  fit_into_steps(bands, rule.steps);
  std::vector<TileLayers> layers(2);
  for (size_t c = 0; c < 2; ++c) {
    if (bands[c].coefficients.empty()) continue;
    choose_steps(bands[c], rule, room.walk);
    bands[c].coefficients = {}; // all that follows is made of steps
    if (!linear) layers[c] = TileLayers(coefficients_of(bands[c], rule.steps), room.layers[c]);
  }
  EncodedTile tile;
  const CodeRange range =
      linear ? read_linear(sites, coder, {sites, coefficients_of(bands[0], rule.steps)}, tile)
             : read_back(sites, coder, std::move(layers), tile);
  Bcc4Chunk& entry = tile.chunk.entry;
  entry.kept = static_cast<uint32_t>(sites.kept());
  for (const ChunkSites& b : sites.bricks) entry.holes += b.holes();
  entry.min_code = range[0], entry.max_code = range[1];
  const RunsPart runs = pack_runs(tile_runs(sites), level);
  std::vector<std::byte>& bytes = tile.chunk.bytes = code_tile(bands, rule.steps, room.walk);
  entry.values_bytes = static_cast<uint32_t>(bytes.size());
  finish_entry(runs, wavelet_part, tile.chunk);
  return tile;
}

} // namespace bccsplat
