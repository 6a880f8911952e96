// SPDX-License-Identifier: Apache-2.0
// Cuts a frame into tiles of bricks that are not all air, and resamples each from the source samples it
// depends on.
#include "fit/resample/resample.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "base/pool.h"
#include "fit/axis/resample_tile.h"
#include "fit/axis/site_axis.h"
#include "fit/beyond/face_table.h"
#include "fit/frame/turned_region.h"

namespace bccsplat {

namespace {

// The samples of an axis of n that indices begin .. end - 1 mean; half-open.
std::array<int64_t, 2> samples_of(const std::array<int64_t, 2>& extended, int64_t n) {
  int64_t first = std::clamp<int64_t>(extended[0], 0, n - 1),
          last = std::clamp<int64_t>(extended[1] - 1, 0, n - 1);
  for (int64_t i = extended[0]; i < extended[1]; ++i) {
    first = std::min(first, mirror_index(i, n));
    last = std::max(last, mirror_index(i, n));
  }
  return {first, last + 1};
}

} // namespace

// A few bricks along x, of both cosets: those that see something, and all they see.
struct SpatialResampler::Tile {
  struct Active {
    size_t coset;
    int x; // brick
    FloatSitesPtr block;
  };
  Int3 brick; // the first one
  std::vector<Active> active;
  Region region{{INT64_MAX, INT64_MAX, INT64_MAX}, {INT64_MIN, INT64_MIN, INT64_MIN}};
  TileRow row{INT64_MAX, INT64_MIN, 0, 0, 0};
  CellRanges::Cell range; // of the samples in the region
};

// The work space of one thread.
struct SpatialResampler::Scratch {
  std::vector<float> rows, extended;
  std::array<std::vector<float>, 2> planes;
  TileBits bits; // samples that are not air
  Reservation memory;

  void fit(size_t row_floats, size_t plane_floats, size_t extended_floats, MemoryBudget& budget) {
    const uint64_t bytes =
        sizeof(float) * (std::max(rows.size(), row_floats) + 2 * std::max(planes[0].size(), plane_floats) +
                         std::max(extended.size(), extended_floats));
    if (bytes > memory.bytes()) {
      memory = {};
      memory = Reservation(budget, bytes, "resampling");
    }
    const auto grow = [](std::vector<float>& v, size_t n) {
      if (v.size() < n) v.resize(n);
    };
    grow(rows, row_floats);
    grow(planes[0], plane_floats);
    grow(planes[1], plane_floats);
    grow(extended, extended_floats);
  }
};

SpatialResampler::SpatialResampler(const Lattice4& lattice, const FaceLevels& faces)
    : turning_(lattice.space.periodic), cosets_(lattice.space.cosets()) {
  double widest = 1;
  for (int c = 0; c < cosets_; ++c) {
    Coset& coset = coset_[c];
    coset.dims = lattice.space.dims(c);
    for (size_t a = 0; a < 3; ++a) {
      n_[a] = lattice.dims[a];
      const double widening = std::max(1.0, lattice.space_step[a] / lattice.space.plane_distance());
      widest = std::max(widest, widening);
      const std::vector<double> positions = site_positions(lattice, c, a);
      Axis& axis = coset.axis[a];
      axis.table = lattice.before[a] + lattice.behind[a] > 0
                       ? face_table(lattice, c, a, widening, end_noises[faces[a]])
                       : filter_table(widening, positions);
      for (const double p : positions)
        axis.nearest.push_back(nearest_sample(p, n_[a] + (turning_[a] ? 1 : 0)));
      for (size_t i = 0; i < positions.size(); ++i)
        axis.near.push_back(near_samples(positions[i], near_source * widening, axis.table, i, axis.nearest[i],
                                         turning_[a], n_[a]));
      for (int32_t begin = 0; begin < coset.dims[a]; begin += brick_edge) {
        const size_t last = std::min(begin + brick_edge, coset.dims[a]) - 1;
        axis.extended.push_back({axis.table.first[begin], axis.table.first[last] + axis.table.taps});
        axis.inside.push_back(turning_[a] ? axis.extended.back() : samples_of(axis.extended.back(), n_[a]));
      }
    }
    const FilterTable& table = coset.axis[0].table;
    const size_t taps = table.taps;
    for (int32_t begin = 0; begin < coset.dims[0]; begin += brick_edge) {
      BrickX& brick = coset.x.emplace_back();
      brick.base = table.first[begin];
      brick.nearest_base = coset.axis[0].nearest[begin];
      brick.weight.assign(taps * brick_edge, 0.0f);
      for (int32_t i = 0; i < brick_edge; ++i) { // sites beyond the last: its place, no weight
        const size_t site = std::min(begin + i, coset.dims[0] - 1);
        brick.index[i] = static_cast<int32_t>(table.first[site] - brick.base);
        brick.nearest_index[i] = static_cast<int32_t>(coset.axis[0].nearest[site] - brick.nearest_base);
        for (size_t k = 0; begin + i < coset.dims[0] && k < taps; ++k)
          brick.weight[k * brick_edge + i] = table.weight[site * taps + k];
      }
    }
  }
  // Wider tiles read less twice, as long as they stay in cache; a widened filter reads more samples per
  // brick.
  constexpr int most_bricks = 4;
  tile_bricks_ = std::clamp(static_cast<int>(most_bricks / widest), 1, most_bricks);
}

Region SpatialResampler::brick_region(const Coset& coset, const Int3& brick) const {
  Region r;
  for (size_t a = 0; a < 3; ++a) {
    r.begin[a] = coset.axis[a].inside[brick[a]][0];
    r.end[a] = coset.axis[a].inside[brick[a]][1];
  }
  return r;
}

SpatialResampler::Tile SpatialResampler::find_tile(const Int3& first, const CellRanges& cells,
                                                   SiteBlockPool& pool) const {
  Tile tile;
  tile.brick = first;
  for (size_t c = 0; c < static_cast<size_t>(cosets_); ++c) {
    const Coset& coset = coset_[c];
    Int3 brick = first;
    if (brick[1] * brick_edge >= coset.dims[1] || brick[2] * brick_edge >= coset.dims[2]) continue;
    for (; brick[0] < first[0] + tile_bricks_ && brick[0] * brick_edge < coset.dims[0]; ++brick[0]) {
      const Region seen = brick_region(coset, brick);
      const CellRanges::Cell range = turned_range(cells, seen, n_, turning_);
      if (range.air()) continue;
      for (size_t a = 0; a < 3; ++a) {
        tile.region.begin[a] = std::min(tile.region.begin[a], seen.begin[a]);
        tile.region.end[a] = std::max(tile.region.end[a], seen.end[a]);
      }
      const auto [low, high] = coset.axis[0].extended[brick[0]];
      tile.row.begin = std::min(tile.row.begin, low);
      tile.row.end = std::max(tile.row.end, high);
      FloatSitesPtr block = pool.floats.take();
      block->largest = std::max({0.0f, -range.low, range.high});
      tile.active.push_back({c, brick[0], std::move(block)});
    }
  }
  if (tile.active.empty()) return tile;
  tile.row.begin = std::min(tile.row.begin, tile.region.begin[0]);
  tile.row.end = std::max(tile.row.end, tile.region.end[0]);
  tile.row.inner_begin = tile.region.begin[0];
  tile.row.inner_end = tile.region.end[0];
  tile.row.n = n_[0];
  tile.range = turned_range(cells, tile.region, n_, turning_);
  return tile;
}

// The `source` bits of sites whose nearest row along y is `y`, from that row of all z.
void SpatialResampler::mark_source(const float* rows, size_t pitch, int64_t y, const Tile& tile,
                                   size_t coset) const {
  const Coset& c = coset_[coset];
  const auto sites = [&](size_t axis) {
    const int begin = tile.brick[axis] * brick_edge;
    return std::span(c.axis[axis].nearest).subspan(begin, std::min(brick_edge, c.dims[axis] - begin));
  };
  const auto along_y = sites(1), along_z = sites(2);
  std::vector<TileNearestX> bricks;
  for (size_t j = 0; j < along_y.size(); ++j) {
    if (along_y[j] != y) continue;
    for (size_t k = 0; k < along_z.size(); ++k) {
      bricks.clear();
      for (const Tile::Active& a : tile.active)
        if (a.coset == coset) {
          const BrickX& x = c.x[a.x];
          bricks.push_back({x.nearest_index.data(), x.nearest_base - tile.region.begin[0],
                            &a.block->source[k * brick_edge + j]});
        }
      tile_nearest(rows + (along_z[k] - tile.region.begin[2]) * pitch, bricks);
    }
  }
}

// The `near` bits of the blocks of a tile.
void SpatialResampler::mark_near(TileBits& bits, const Tile& tile, size_t coset) const {
  const Coset& c = coset_[coset];
  const auto near = [&](size_t axis, int brick) {
    std::vector<SampleSpan> list;
    const size_t begin = brick * brick_edge;
    for (size_t i = begin; i < std::min(begin + brick_edge, c.axis[axis].near.size()); ++i) {
      const auto& [first, last] = c.axis[axis].near[i];
      const int64_t base = tile.region.begin[axis];
      list.push_back({static_cast<size_t>(first - base), static_cast<size_t>(last - base)});
    }
    return list;
  };
  struct Along {
    FloatSites* block;
    SpanGroup x;
  };
  std::vector<Along> bricks;
  for (const Tile::Active& a : tile.active) {
    if (a.coset != coset) continue;
    a.block->near.fill(0);
    bricks.push_back({a.block.get(), SpanGroup(near(0, a.x))});
  }
  bits.for_rows(near(1, tile.brick[1]), near(2, tile.brick[2]), [&](size_t j, size_t k, const uint64_t* row) {
    for (const Along& b : bricks) b.block->near[k * brick_edge + j] = static_cast<uint16_t>(b.x.any(row));
  });
}

void SpatialResampler::resample_tile(const Frame& frame, const Tile& tile, Scratch& scratch,
                                     const Context& context) const {
  const Region& region = tile.region;
  const bool known = !tile.range.broken, no_air = known && (tile.range.low > 0 || tile.range.high < 0);
  if (no_air)
    for (const Tile::Active& a : tile.active) a.block->source.fill(0xffff), a.block->near.fill(0xffff);
  if (known && tile.range.low == tile.range.high) {
    for (const Tile::Active& a : tile.active) a.block->value.fill(tile.range.low);
    return;
  }
  // Samples that vary little around a large value are resampled as their difference from it: the weights sum
  // to 1, and floats would lose the variation (and a constant would not stay one). The difference is exact
  // (Sterbenz) within a factor of 2; air never takes part.
  float pivot = 0;
  if (no_air && tile.range.low > 0 && tile.range.high <= 2 * tile.range.low)
    pivot = tile.range.low;
  else if (no_air && tile.range.high < 0 && tile.range.low >= 2 * tile.range.high)
    pivot = tile.range.high;

  const auto width = static_cast<size_t>(region.length(0)), ny = static_cast<size_t>(region.length(1)),
             nz = static_cast<size_t>(region.length(2)), pitch = (width + 15) / 16 * 16;
  const TurnedFrame turned(frame, region, turning_);
  // One y at a time keeps its z rows in the first cache; many boxes are better walked less often.
  const size_t rows_at_once = turned.boxes() > 4 ? 8 : 1;
  scratch.fit(rows_at_once * nz * pitch + 64, ny * brick_edge * pitch,
              (tile.row.end - tile.row.begin) + pitch + 64, context.memory);

  std::array<TileTaps, 2> z, y;
  std::array<std::vector<int32_t>, 2> z_rows, y_rows;
  for (const Tile::Active& a : tile.active) { // set for the cosets that take part
    z[a.coset] = tile_taps(2, coset_[a.coset], tile.brick[2], region.begin[2], z_rows[a.coset]);
    y[a.coset] = tile_taps(1, coset_[a.coset], tile.brick[1], region.begin[1], y_rows[a.coset]);
  }
  if (!no_air) scratch.bits.clear(width, ny, nz);
  for (size_t y0 = 0; y0 < ny; y0 += rows_at_once) {
    Region part = region;
    part.begin[1] = region.begin[1] + static_cast<int64_t>(y0);
    part.end[1] = std::min(region.end[1], part.begin[1] + static_cast<int64_t>(rows_at_once));
    turned.read(part, scratch.rows.data(), nz * pitch, pitch);
    const size_t count = part.length(1);
    if (!no_air)
      for (size_t i = 0; i < count; ++i)
        for (size_t k = 0; k < nz; ++k)
          scratch.bits.add_row(scratch.rows.data() + (i * nz + k) * pitch, y0 + i, k);
    if (pivot != 0)
      for (size_t i = 0; i < count * nz * pitch; ++i) scratch.rows[i] -= pivot;
    for (size_t c = 0; c < 2; ++c)
      for (size_t i = 0; z[c].count > 0 && i < count; ++i) {
        const float* rows = scratch.rows.data() + i * nz * pitch;
        if (!no_air) mark_source(rows, pitch, part.begin[1] + static_cast<int64_t>(i), tile, c);
        tile_pass_z(rows, pitch, z[c], scratch.planes[c].data() + (y0 + i) * z[c].count * pitch);
      }
  }
  for (size_t c = 0; c < 2; ++c) {
    if (z[c].count == 0) continue;
    if (!no_air) mark_near(scratch.bits, tile, c);
    std::vector<TileBrickX> bricks;
    for (const Tile::Active& a : tile.active)
      if (a.coset == c) {
        const BrickX& x = coset_[c].x[a.x];
        bricks.push_back({x.weight.data(), x.index.data(), x.base - tile.row.begin, a.block->value.data()});
      }
    tile_pass_yx(scratch.planes[c].data(), pitch, z[c].count, y[c], tile.row, coset_[c].axis[0].table.taps,
                 bricks, pivot, scratch.extended.data());
  }
}

TileTaps SpatialResampler::tile_taps(size_t axis, const Coset& coset, int32_t brick, int64_t first_row,
                                     std::vector<int32_t>& rows) const {
  const FilterTable& table = coset.axis[axis].table;
  const int begin = brick * brick_edge, end = std::min(begin + brick_edge, coset.dims[axis]);
  rows.clear();
  for (int i = begin; i < end; ++i)
    for (int k = 0; k < table.taps; ++k) {
      const int64_t at = table.first[i] + k;
      rows.push_back(static_cast<int32_t>((turning_[axis] ? at : mirror_index(at, n_[axis])) - first_row));
    }
  return {table.taps, end - begin, table.weight.data() + static_cast<ptrdiff_t>(begin) * table.taps,
          rows.data()};
}

void SpatialResampler::keep_tile(Tile tile, float unit, SiteBlockPool& pool, FrameSites& sites) const {
  for (Tile::Active& a : tile.active) {
    const Coset& coset = coset_[a.coset];
    const Int3 brick{a.x, tile.brick[1], tile.brick[2]};
    Int3 size;
    for (size_t d = 0; d < 3; ++d) size[d] = std::min(brick_edge, coset.dims[d] - brick[d] * brick_edge);
    sites.block[a.coset][slot(coset, brick)] = pack(std::move(a.block), size, unit, pool);
  }
}

BrickBox SpatialResampler::inside(BrickBox bricks) const {
  const Int3 all = brick_dims(coset_[0]); // those of coset 1 are no more
  for (size_t a = 0; a < 3; ++a) bricks.end[a] = std::min(bricks.end[a], all[a]);
  return bricks;
}

BrickBox SpatialResampler::whole_tiles(BrickBox bricks) const {
  bricks = inside(bricks);
  const int32_t end = (bricks.end[0] + tile_bricks_ - 1) / tile_bricks_ * tile_bricks_;
  if (bricks.begin[0] < bricks.end[0]) bricks.begin[0] -= bricks.begin[0] % tile_bricks_, bricks.end[0] = end;
  return inside(bricks);
}

Region SpatialResampler::seen_by(const BrickBox& bricks) const {
  const BrickBox box = inside(bricks);
  Region all;
  for (size_t a = 0; a < 3; ++a) {
    all.begin[a] = INT64_MAX, all.end[a] = INT64_MIN;
    for (int32_t b = box.begin[a]; b < box.end[a]; ++b)
      for (int c = 0; c < cosets_; ++c) {
        const auto& seen = coset_[c].axis[a].inside;
        if (b >= static_cast<int32_t>(seen.size())) continue; // coset 1 may lack the last one
        all.begin[a] = std::min(all.begin[a], seen[b][0]);
        all.end[a] = std::max(all.end[a], seen[b][1]);
      }
    if (all.begin[a] > all.end[a]) return {};
  }
  return all;
}

FrameSites SpatialResampler::resample(const Frame& frame, const CellRanges& cells, float unit,
                                      SiteBlockPool& pool, const Context& context,
                                      const BrickBox& made) const {
  FrameSites sites;
  for (size_t c = 0; c < static_cast<size_t>(cosets_); ++c) sites.block[c].resize(slots(coset_[c]));
  std::vector<Int3> tiles;
  const BrickBox bricks = inside(made);
  for (int32_t z = bricks.begin[2]; z < bricks.end[2]; ++z)
    for (int32_t y = bricks.begin[1]; y < bricks.end[1]; ++y)
      for (int32_t x = bricks.begin[0]; x < bricks.end[0]; x += tile_bricks_) tiles.push_back({x, y, z});

  Pool<Scratch> scratches;
  context.tasks.parallel_for(tiles.size(), [&](uint64_t i) {
    context.progress.check();
    Tile tile = find_tile(tiles[i], cells, pool);
    if (tile.active.empty()) return;
    auto scratch = scratches.take([] { return std::make_unique<Scratch>(); });
    resample_tile(frame, tile, *scratch, context);
    keep_tile(std::move(tile), unit, pool, sites);
    scratches.give_back(std::move(scratch));
  });
  return sites;
}

} // namespace bccsplat
