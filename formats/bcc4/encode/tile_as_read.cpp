// SPDX-License-Identifier: Apache-2.0
// Compares codes one after the other, and samples of linear tiles in lanes.
#include "formats/bcc4/encode/tile_as_read.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <utility>

#include "formats/bcc4/coding/chunk_rows.h"
#include "formats/bcc4/coding/layer_codes.h"
#include "formats/bcc4/coding/open_tile.h"
#include "points/rounded_brick.h"

namespace bccsplat {
namespace {

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

} // namespace

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

namespace {

// A brick of a layer without its values.
Brick begun_brick(const LinearTile& tile, int brick, int layer) {
  Brick begun;
  begun.kept = tile.kept(brick, layer);
  if (tile.hole(brick, layer) != BrickMask{})
    begun.hole = std::make_unique<BrickMask>(tile.hole(brick, layer));
  return begun;
}

// Samples as a reader gets them, but for a rounding that is next to nothing beside a code.
SampleBrick as_read(Brick&& brick, const SampleCoder& coder) {
  constexpr double of_code = as_read_rounding;
  const float coarsest = std::exp2(std::floor(std::log2(static_cast<float>(of_code * coder.scale()))));
  if (auto rounded = RoundedBrick::round(brick, coarsest)) return {nullptr, std::move(rounded)};
  return {std::make_shared<const Brick>(std::move(brick)), nullptr};
}

// What is summed of the samples that a reader gets, in lanes.
class ReadSums {
 public:
  explicit ReadSums(const SampleCoder& coder)
      : scale_(static_cast<float>(coder.scale())), air_(coder.decode(coder.codes().air)),
        air_code_(static_cast<float>(coder.codes().air)) {
    low_.fill(std::numeric_limits<float>::infinity());
    high_.fill(-std::numeric_limits<float>::infinity());
  }
  double squares = 0; // of their distances from the codes that were wanted

  // Makes the values of a brick. box: its layer; wanted: its codes, one after the other.
  void read_brick(const LinearTile& tile, int brick, std::span<const float> box, const uint32_t*& wanted,
                  Brick& to) {
    const BrickRows rows = tile.rows(brick);
    of_brick_ = {};
    for (size_t r = 0; r < brick_rows; ++r) {
      const unsigned kept = to.kept[r];
      const float* const from =
          box.data() + rows.first + r / brick_edge * rows.plane + r % brick_edge * rows.row;
      float* const values = to.value.data() + r * brick_edge;
      if (kept == whole_row) {
        for (size_t x = 0; x < brick_edge; ++x) values[x] = read(from[x], wanted[x], x);
        wanted += brick_edge;
        continue;
      }
      std::fill_n(values, brick_edge, 0.F);
      for (unsigned bits = kept; bits; bits &= bits - 1) {
        const size_t x = std::countr_zero(bits);
        values[x] = read(from[x], *wanted++, x);
      }
    }
    for (const float s : of_brick_) squares += s;
  }
  [[nodiscard]] LinearRange range() const {
    return {*std::min_element(low_.begin(), low_.end()), *std::max_element(high_.begin(), high_.end())};
  }

 private:
  float read(float sample, uint32_t wanted, size_t lane) {
    const float off = sample + air_code_ - static_cast<float>(static_cast<int32_t>(wanted));
    of_brick_[lane] += off * off;
    low_[lane] = sample < low_[lane] ? sample : low_[lane];
    high_[lane] = sample > high_[lane] ? sample : high_[lane];
    return scale_ * sample + air_;
  }

  float scale_, air_, air_code_;
  std::array<float, brick_edge> of_brick_{}, low_, high_;
};

} // namespace

CodeRange read_linear(const TileSites& sites, const SampleCoder& coder, const LinearTile& back,
                      EncodedTile& tile) {
  const int layers = sites.place.layers;
  ReadSums sums(coder);
  tile.bricks.resize(size_t(sites.place.bricks()) * layers);
  std::vector<const uint32_t*> next;
  for (const ChunkSites& b : sites.bricks) next.push_back(b.codes.data());
  std::vector<float> box;
  for (int m = 0; m < layers; ++m) {
    back.make_layer(m, box);
    for (int i = 0; i < sites.place.bricks(); ++i) {
      if (back.kept(i, m) == BrickMask{}) continue;
      Brick brick = begun_brick(back, i, m);
      sums.read_brick(back, i, box, next[i], brick);
      tile.bricks[size_t(i) * layers + m] = as_read(std::move(brick), coder);
    }
  }
  tile.squared_error += sums.squares;
  return sums.range().nearest(coder.codes());
}

namespace {

void read_bricks(const LinearTile& tile, const SampleCoder& coder, std::vector<SampleBrick>& bricks) {
  const auto scale = static_cast<float>(coder.scale()), air = coder.decode(coder.codes().air);
  std::vector<float> box;
  for (int m = 0; m < tile.layers(); ++m) {
    tile.make_layer(m, box);
    for (int i = 0; i < tile.bricks(); ++i) {
      if (tile.kept(i, m) == BrickMask{}) continue;
      Brick brick = begun_brick(tile, i, m);
      brick.value.fill(0);
      for_kept(tile, i, m, box, [&](size_t site, float sample) { brick.value[site] = scale * sample + air; });
      bricks[size_t(i) * tile.layers() + m] = as_read(std::move(brick), coder);
    }
  }
}

void read_bricks(const OpenTile& tile, const SampleCoder& coder, int layers,
                 std::vector<SampleBrick>& bricks) {
  for (size_t i = 0; i < tile.bricks().size(); ++i) {
    const auto& first = tile.bricks()[i].first;
    for (int m = 0; m < layers; ++m)
      if (first[m + 1] != first[m])
        bricks[i * layers + m].codes =
            std::make_shared<const LayerCodes>(coder, tile, static_cast<int>(i), m);
  }
}

} // namespace

std::vector<SampleBrick> read_stored(const TilePlace& place, const SampleCoder& coder, bool linear,
                                     const Bcc4Chunk& entry, std::span<const std::byte> bytes,
                                     ChunkScratch& scratch) {
  std::vector<SampleBrick> bricks(size_t(place.bricks()) * place.layers);
  if (linear)
    read_bricks(LinearTile(place, coder.codes(), entry, bytes, scratch), coder, bricks);
  else
    read_bricks(OpenTile(place, coder.codes(), entry, bytes, scratch), coder, place.layers, bricks);
  return bricks;
}

} // namespace bccsplat
