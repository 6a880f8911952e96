// SPDX-License-Identifier: Apache-2.0
// Holds one mask of a brick where all layers keep the same sites.
#include "formats/bcc4/coding/linear_tile.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "formats/bcc4/coding/chunk_parts.h"
#include "formats/bcc4/coding/chunk_rows.h"
#include "formats/bcc4/coding/scratch.h"
#include "formats/bcc4/coding/tile_rows.h"
#include "formats/bcc4/coding/tile_runs.h"
#include "formats/bcc4/wavelet/step_walk.h"

namespace bccsplat {
namespace {

constexpr BrickMask no_sites{};

} // namespace

TileMasks::TileMasks(std::vector<BrickMask> layers) : masks_(std::move(layers)) {
  if (std::all_of(masks_.begin(), masks_.end(), [](const BrickMask& m) { return m == no_sites; }))
    masks_.clear();
  else if (std::all_of(masks_.begin(), masks_.end(), [&](const BrickMask& m) { return m == masks_[0]; }))
    masks_.resize(1);
  masks_.shrink_to_fit();
}

const BrickMask& TileMasks::of(int layer) const {
  if (masks_.empty()) return no_sites;
  return masks_[masks_.size() == 1 ? 0 : layer];
}

template<class Bricks> void LinearTile::take_masks(const Bricks& bricks) {
  for (const auto& b : bricks) {
    kept_.emplace_back(b.kept);
    hole_.emplace_back(b.hole);
  }
}

LinearTile::LinearTile(const TilePlace& place, const ChunkCodes& codes, const Bcc4Chunk& entry,
                       std::span<const std::byte> bytes, ChunkScratch& scratch)
    : edge_(place.edge), layers_(place.layers) {
  check_stored(entry, bytes);
  take_masks(read_tile_runs(place, codes, entry, bytes, scratch));
  const TileBox box = place.boxes().front();
  coefficients_ = std::move(
      decode_tile({&box, 1}, bytes.first(entry.values_bytes), entry.offset, scratch.room.walk).front());
}

LinearTile::LinearTile(const TileSites& sites, TileCoefficients coefficients)
    : edge_(sites.place.edge), layers_(sites.place.layers), coefficients_(std::move(coefficients)) {
  take_masks(sites.bricks);
}

LinearTile::LinearTile(const TilePlace& place)
    : edge_(place.edge), layers_(place.layers),
      coefficients_(halved(place.boxes().front().size, {}), cosine_basis(place.layers)) {
  for (int i = 0; i < place.bricks(); ++i) {
    std::vector<BrickMask> all(place.layers, BrickMask{});
    for_rows(shape_at(place, i),
             [&](size_t m, size_t r, int width) { all[m][r] = static_cast<uint16_t>((1u << width) - 1); });
    kept_.emplace_back(all);
    hole_.emplace_back(std::move(all));
  }
}

bool LinearTile::keeps_alike() const {
  return std::all_of(kept_.begin(), kept_.end(), [](const TileMasks& m) { return m.alike(); });
}

bool LinearTile::adds_to(const LinearTile& other) const {
  const Halvings &a = coefficients_.shape(), &b = other.coefficients_.shape();
  return a.size == b.size && a.times == b.times && kept_ == other.kept_;
}

BrickRows LinearTile::rows(int brick) const {
  const auto& n = coefficients_.shape().size;
  const size_t x = brick % edge_, y = brick / edge_ % edge_, z = brick / edge_ / edge_;
  BrickRows rows{0, static_cast<size_t>(n[0]), static_cast<size_t>(n[0]) * n[1]};
  rows.first = brick_edge * (x + y * rows.row + z * rows.plane);
  return rows;
}

void LinearTile::make_layer(int layer, std::vector<float>& box) const {
  std::vector<float> weights(layers_);
  weights[layer] = 1;
  box.assign(coefficients_.shape().samples(), 0);
  coefficients_.add_to(box, weights);
  synthesise(coefficients_.shape(), box);
}

CodeRange LinearTile::range(const ChunkCodes& codes) const {
  LinearRange all;
  std::vector<float> box;
  for (int m = 0; m < layers_; ++m) {
    make_layer(m, box);
    for (int i = 0; i < bricks(); ++i)
      for_kept(*this, i, m, box, [&](size_t, float sample) { all.add(sample); });
  }
  return all.nearest(codes);
}

uint64_t LinearTile::bytes() const {
  uint64_t sum = sizeof *this + (kept_.size() + hole_.size()) * sizeof(TileMasks) + coefficients_.bytes();
  for (const TileMasks& m : kept_) sum += m.bytes();
  for (const TileMasks& m : hole_) sum += m.bytes();
  return sum;
}

CodeRange LinearRange::nearest(const ChunkCodes& codes) const {
  const auto code = [&](float sample) {
    constexpr float half = .5F;
    const float found = std::floor(sample + static_cast<float>(codes.air) + half);
    return static_cast<uint32_t>(std::clamp(found, 0.F, static_cast<float>(codes.mask())));
  };
  return {code(low), code(high)};
}

} // namespace bccsplat
