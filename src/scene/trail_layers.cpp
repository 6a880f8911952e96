// SPDX-License-Identifier: Apache-2.0
// Makes the stills of a trail sums of the lattice's layers, with the weights of a time slice, so that layers
// and not stills are splatted. A layer alone says nothing of what a sum shows, so that the ranges by which
// bricks and cells are left out are bounds of the sums.
#include "scene/trail_layers.h"

#include <algorithm>
#include <map>

#include "field/corrections.h"
#include "slice/time_slice.h"
#include "splat/points/cell_ranges.h"

namespace bccsplat {
namespace {

// Layers are taken where there are this many times as many stills. A layer holds one coset's points, a still
// all of them, but of a still more is known to be invisible (tests/bench/notes/trail.md).
constexpr double stills_per_layer = 1.25;

// Widens the ranges of cells by those of another brick.
void widen(BrickCells& cells, const BrickCells& by) {
  for (size_t c = 0; c < cells_per_brick; ++c) {
    cells.low[c] = std::min(cells.low[c], by.low[c]);
    cells.high[c] = std::max(cells.high[c], by.high[c]);
  }
}

// Returns the ranges of a layer's brick alone, with 0: it holds one coset's points, so that every cell has
// sites without one.
BrickCells cells_of(const SplatPoints& points, const SplatBrick& brick) {
  BrickCells cells;
  for (uint32_t n = brick.first; n < brick.first + brick.count; ++n) {
    const unsigned p = points.position[n];
    const unsigned cell = (p >> 2 & 3) | (p >> 4 & 12) | (p >> 6 & 48);
    cells.low[cell] = std::min(cells.low[cell], points.coefficient[n]);
    cells.high[cell] = std::max(cells.high[cell], points.coefficient[n]);
  }
  return cells;
}

// The bricks of all layers: their slots, and the number of each layer's own one.
struct LayerBricks {
  SlotSet slots;
  size_t count = 0;
  static constexpr uint32_t none = UINT32_MAX;
  std::vector<std::vector<uint32_t>> of; // by slot's number and layer

  explicit LayerBricks(const Trail& trail) : slots(slots_of(trail.sources.front().points)) {
    for (const TrailSource& s : trail.sources)
      for (const SplatBrick& b : s.points.bricks) slots.add(s.points.slot(b));
    count = slots.list().size();
    of.assign(count, std::vector<uint32_t>(trail.sources.size(), none));
    for (size_t i = 0; i < trail.sources.size(); ++i) {
      const SplatPoints& points = trail.sources[i].points;
      for (uint32_t n = 0; n < points.bricks.size(); ++n) of[number(points.slot(points.bricks[n]))][i] = n;
    }
  }
  [[nodiscard]] size_t number(uint64_t slot) const { return slots.number(slot); }
  static uint64_t slots_of(const SplatPoints& points) {
    uint64_t product = 1;
    for (const int n : points.dims) product *= n;
    return product;
  }
};

// Returns, for each layer, bounds of the sums in a brick's cells over the moments that the layer takes part
// in. `coset` is that of each layer.
std::vector<BrickCells> bound_sums(const Trail& trail, const std::vector<size_t>& coset,
                                   const std::vector<uint32_t>& bricks) {
  std::vector<BrickCells> own(bricks.size()), bound(bricks.size());
  for (size_t i = 0; i < bricks.size(); ++i)
    if (const SplatPoints& p = trail.sources[i].points; bricks[i] != LayerBricks::none)
      own[i] = cells_of(p, p.bricks[bricks[i]]);
  for (const TrailMoment& m : trail.moments) {
    std::array<BrickCells, 2> sum; // by coset
    for (const SheetShare& share : m.shares) {
      if (bricks[share.source] == LayerBricks::none) continue;
      BrickCells& to = sum[coset[share.source]];
      for (size_t c = 0; c < cells_per_brick; ++c) {
        to.low[c] += share.weight * own[share.source].low[c]; // no weight is negative
        to.high[c] += share.weight * own[share.source].high[c];
      }
    }
    widen(sum[0], sum[1]);
    for (const SheetShare& share : m.shares) widen(bound[share.source], sum[0]);
  }
  return bound;
}

// Sets what is known around the bricks and cells of each layer's points to bounds of the sums.
void bound_layers(Trail& trail, const std::vector<size_t>& coset, const Context& context) {
  const size_t layers = trail.sources.size();
  const LayerBricks bricks(trail);
  const Reservation memory(context.memory, layers * bricks.count * sizeof(BrickCells),
                           "the cells of a trail's layers");
  std::vector<std::vector<BrickCells>> bound(layers, std::vector<BrickCells>(bricks.count));
  context.tasks.parallel_for(bricks.count, [&](uint64_t n) {
    context.progress.check();
    const auto cells = bound_sums(trail, coset, bricks.of[n]);
    for (size_t i = 0; i < layers; ++i) bound[i][n] = cells[i];
  });
  std::vector<std::array<float, 2>> range(layers);
  context.tasks.parallel_for(layers, [&](uint64_t i) {
    context.progress.check();
    SplatPoints& points = trail.sources[i].points;
    points.codes.clear();                    // of a layer alone
    std::vector<std::array<float, 2>> whole; // bricks
    for (const BrickCells& cells : bound[i])
      whole.push_back({*std::min_element(cells.low.begin(), cells.low.end()),
                       *std::max_element(cells.high.begin(), cells.high.end())});
    const auto widen_by = [](float* r, const std::array<float, 2>& by) {
      r[0] = std::min(r[0], by[0]), r[1] = std::max(r[1], by[1]);
    };
    for (const auto& w : whole) widen_by(range[i].data(), w);
    CellCube cube;
    for (size_t n = 0; n < points.bricks.size(); ++n) {
      SplatBrick& b = points.bricks[n];
      Int3 at;
      for (size_t a = 0; a < 3; ++a) at[a] = (b.plane[a] + points.margin) / points.edge;
      b.reach[0] = b.reach[1] = 0;
      for (int z = std::max(0, at[2] - 1); z <= std::min(points.dims[2] - 1, at[2] + 1); ++z)
        for (int y = std::max(0, at[1] - 1); y <= std::min(points.dims[1] - 1, at[1] + 1); ++y)
          for (int x = std::max(0, at[0] - 1); x <= std::min(points.dims[0] - 1, at[0] + 1); ++x) {
            const int64_t beside =
                bricks.slots.number((int64_t{z} * points.dims[1] + y) * points.dims[0] + x);
            if (beside >= 0) widen_by(b.reach, whole[beside]);
          }
      gather_cells(bound[i], bricks.slots, points.dims, at, points.edge / 4, cube);
      WidenedCells out;
      for (size_t r = 0; r < out.size(); ++r) out[r] = points.cells[r].data() + n * cells_per_brick;
      widen_cells(cube, out);
    }
  });
  std::array<float, 2> all{};
  for (const auto& [low, high] : range) all = {std::min(all[0], low), std::max(all[1], high)};
  trail.bounds = coefficient_bounds(trail.sources.front().slice, all);
}

bool has_holes(const BrickLayer& layer) {
  for (size_t s = 0; s < layer.brick_slots(); ++s)
    if (layer.brick(s) && layer.brick(s)->hole) return true;
  return false;
}

} // namespace

void add_source(Trail& trail, Slice&& slice, const Context& context) {
  TrailSource s;
  s.memory = Reservation(context.memory, slice.bytes(), "a moment of the trail");
  s.points = make_points(slice, context);
  s.slice = std::move(slice);
  trail.sources.push_back(std::move(s));
}

bool add_layers(Trail& trail, const Coefficients& coefficients, const Slice& like,
                const std::vector<Moment>& moments, const Context& context) {
  // Corrections and masks of a still are not sums of those of layers.
  if (const Corrections* fix = coefficients.corrections(); (fix && fix->any()) || coefficients.masks())
    return false;
  const Lattice4& lattice = coefficients.source().lattice();
  std::vector<std::vector<LayerWeight>> weights;
  std::vector<int32_t> wanted;
  for (const Moment& m : moments) {
    weights.push_back(instant_weights(lattice, coefficients.kernel(), m.at));
    for (const LayerWeight& w : weights.back()) wanted.push_back(w.layer);
  }
  std::sort(wanted.begin(), wanted.end());
  wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
  const double stills = static_cast<double>(moments.size()) * lattice.space.cosets() / 2;
  if (stills_per_layer * static_cast<double>(wanted.size()) >= stills) return false;
  const auto layers = coefficients.layers(wanted, context);
  for (const auto& layer : layers)
    if (has_holes(*layer)) return false;

  std::vector<size_t> coset_of; // source
  std::map<int32_t, uint32_t> source;
  std::map<const BrickLayer*, uint32_t> known; // mirror images beyond the ends are the same layer
  for (size_t i = 0; i < wanted.size(); ++i) {
    const auto [at, is_new] = known.try_emplace(layers[i].get(), static_cast<uint32_t>(trail.sources.size()));
    source[wanted[i]] = at->second;
    if (!is_new) continue;
    Slice slice = like;
    const int coset = lattice.coset(wanted[i]);
    slice.coset[coset] = *layers[i];
    if (lattice.space.cosets() > 1) slice.coset[1 - coset] = BrickLayer(lattice.space, 1 - coset);
    slice.has_holes = false;
    add_source(trail, std::move(slice), context);
    coset_of.push_back(coset);
  }
  for (size_t n = 0; n < moments.size(); ++n) {
    TrailMoment m{{}, moments[n].at, moments[n].weight, moments[n].interval};
    for (const LayerWeight& w : weights[n]) {
      const uint32_t s = source[w.layer];
      const auto same =
          std::find_if(m.shares.begin(), m.shares.end(), [&](const SheetShare& x) { return x.source == s; });
      if (same != m.shares.end())
        same->weight += w.weight;
      else
        m.shares.push_back({s, w.weight});
    }
    trail.moments.push_back(std::move(m));
  }
  bound_layers(trail, coset_of, context);
  return true;
}

} // namespace bccsplat
