// SPDX-License-Identifier: Apache-2.0
// Tiles that keep the same sites in all of these layers go through one inverse; where layers of a tile keep
// other sites than others do, each is made by itself.
#include "formats/bcc4/read/tile_sums.h"

#include <algorithm>
#include <bit>
#include <numeric>
#include <utility>

#include "base/page_pool.h"

namespace bccsplat {
namespace {

// Layers of a tile that keep the sites which `layer` keeps.
struct Summand {
  const LinearTile* tile;
  int layer;
  std::vector<float> weights;
  [[nodiscard]] float total() const { return std::accumulate(weights.begin(), weights.end(), 0.F); }
};

std::vector<Summand> summands(std::span<const WeighedTile> tiles) {
  std::vector<Summand> out;
  for (const auto& [tile, weights] : tiles) {
    if (!tile) continue;
    if (tile->keeps_alike()) {
      out.push_back({tile, 0, weights});
      continue;
    }
    for (int m = 0; m < tile->layers(); ++m) {
      if (weights[m] == 0) continue;
      Summand one{tile, m, std::vector<float>(weights.size())};
      one.weights[m] = weights[m];
      out.push_back(std::move(one));
    }
  }
  return out;
}

// Adds to a row, or sets it to, what it is made of: 16 values beyond its first one may be read.
void add_row(const float* box, unsigned kept, float scale, float add, bool first, float* to) {
  constexpr unsigned all = (1u << brick_edge) - 1;
  if (first && kept == all) {
    for (int x = 0; x < brick_edge; ++x) to[x] = scale * box[x] + add;
    return;
  }
  if (first) std::fill_n(to, brick_edge, 0.F);
  if (kept == all) {
    for (int x = 0; x < brick_edge; ++x) to[x] += scale * box[x] + add;
    return;
  }
  for (unsigned bits = kept; bits; bits &= bits - 1) {
    const int x = std::countr_zero(bits);
    to[x] += scale * box[x] + add;
  }
}

class Sum {
 public:
  Sum(const TileValues& values, const std::vector<bool>& wanted)
      : values_(values), wanted_(wanted), bricks_(wanted.size()) {}

  // Returns the part of a summand that will be added: nothing where an end is not beyond its first.
  [[nodiscard]] BoxPart part_of(const Summand& of) const {
    const auto& size = of.tile->coefficients().shape().size;
    BoxPart part{size, {0, 0, 0}};
    for (size_t i = 0; i < wanted_.size(); ++i) {
      const int brick = static_cast<int>(i), edge = of.tile->edge();
      if (!wanted_[i] || of.tile->kept(brick, of.layer) == BrickMask{}) continue;
      const std::array<int, 3> at{brick % edge, brick / edge % edge, brick / edge / edge};
      for (int axis = 0; axis < 3; ++axis) {
        part.first[axis] = std::min(part.first[axis], at[axis] * int{brick_edge});
        part.end[axis] = std::max(part.end[axis], std::min((at[axis] + 1) * int{brick_edge}, size[axis]));
      }
    }
    return part;
  }

  // box: the summand and others like it, put together; total: of all their weights.
  void add(const Summand& of, std::span<const float> box, float total) {
    for (size_t i = 0; i < bricks_.size(); ++i) {
      const BrickMask& kept = of.tile->kept(static_cast<int>(i), of.layer);
      if (!wanted_[i] || kept == BrickMask{}) continue;
      std::shared_ptr<Brick>& brick = bricks_[i];
      const bool first = !brick;
      if (first) brick = make_pooled_for_overwrite<Brick>();
      const BrickRows rows = of.tile->rows(static_cast<int>(i));
      for (size_t r = 0; r < brick_rows; ++r) {
        if (kept[r] == 0 && !first) continue;
        const size_t at = rows.first + r / brick_edge * rows.plane + r % brick_edge * rows.row;
        add_row(box.data() + at, kept[r], values_.scale, values_.air * total, first,
                brick->value.data() + r * brick_edge);
        brick->kept[r] |= kept[r];
      }
    }
  }

  // What sites count for that these layers do not keep, but others do.
  void add_absent(const LinearTile* tile, int layer, float total) {
    if (values_.absent == 0 || total == 0) return;
    for (size_t i = 0; i < bricks_.size(); ++i) {
      if (!bricks_[i]) continue;
      Brick& brick = *bricks_[i];
      for (size_t r = 0; r < brick_rows; ++r) {
        unsigned bits = brick.kept[r];
        if (tile) bits &= ~unsigned{tile->kept(static_cast<int>(i), layer)[r]};
        for (; bits; bits &= bits - 1)
          brick.value[r * brick_edge + std::countr_zero(bits)] += values_.absent * total;
      }
    }
  }
  [[nodiscard]] std::vector<std::shared_ptr<Brick>> take() { return std::move(bricks_); }

 private:
  const TileValues& values_;
  const std::vector<bool>& wanted_;
  std::vector<std::shared_ptr<Brick>> bricks_;
};

} // namespace

std::vector<std::shared_ptr<Brick>> sum_tiles(std::span<const WeighedTile> tiles, const TileValues& values,
                                              const std::vector<bool>& wanted, std::vector<float>& room) {
  const std::vector<Summand> parts = summands(tiles);
  if (parts.empty()) return {};
  Sum sum(values, wanted);
  for (size_t i = 0; i < parts.size();) {
    const Summand& first = parts[i];
    const Halvings& shape = first.tile->coefficients().shape();
    const BoxPart part = sum.part_of(first);
    room.assign(shape.samples() + brick_edge, 0); // rows are read whole
    const auto box = std::span(room).first(shape.samples());
    float total = 0;
    do {
      parts[i].tile->coefficients().add_to(box, parts[i].weights);
      total += parts[i].total();
    } while (++i < parts.size() && first.tile->keeps_alike() && parts[i].tile->keeps_alike() &&
             parts[i].tile->adds_to(*first.tile));
    if (part.end[0] <= part.first[0]) continue;
    synthesise(shape, part, box);
    sum.add(first, room, total);
  }
  for (const Summand& part : parts) sum.add_absent(part.tile, part.layer, part.total());
  for (const auto& [tile, weights] : tiles)
    if (!tile) sum.add_absent(nullptr, 0, std::accumulate(weights.begin(), weights.end(), 0.F));
  return sum.take();
}

} // namespace bccsplat
