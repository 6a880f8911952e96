#include "render/trail_layers.h"

#include <algorithm>
#include <map>

#include "slice/time_slice.h"

namespace bccsplat {
namespace {

// Bricks by number, x fastest.
size_t brick_slot(const SplatPoints& p, const SplatBrick& b) {
  size_t slot = 0;
  for (size_t a = 3; a-- > 0;)
    slot = slot * static_cast<size_t>(p.dims[a]) + static_cast<size_t>((b.plane[a] + p.margin) / p.edge);
  return slot;
}

// What values the moments made of a source may have around each of its bricks. The sum of a moment's layers
// at a site is at most `gain` times their largest value.
void bound_bricks(Trail& trail, float gain) {
  const SplatPoints& grid = trail.sources.front().points;
  const size_t slots = static_cast<size_t>(grid.dims[0]) * static_cast<size_t>(grid.dims[1]) *
                       static_cast<size_t>(grid.dims[2]);
  using Range = std::array<float, 2>;
  const auto widen = [](Range& r, const Range& by) { r = {std::min(r[0], by[0]), std::max(r[1], by[1])}; };
  std::vector<std::vector<Range>> own, reach(trail.sources.size(), std::vector<Range>(slots));
  Range all{};
  for (const TrailSource& s : trail.sources) {
    own.emplace_back(slots);
    for (const SplatBrick& b : s.points.bricks)
      own.back()[brick_slot(s.points, b)] = {gain * b.coefficient[0], gain * b.coefficient[1]};
  }
  std::vector<Range> sum(slots), around(slots);
  for (const TrailMoment& m : trail.moments) {
    std::fill(sum.begin(), sum.end(), Range{});
    for (const SheetShare& share : m.shares)
      for (size_t n = 0; n < slots; ++n) widen(sum[n], own[share.source][n]);
    for (const Range& r : sum) widen(all, r);
    // The 27-neighbourhood, axis by axis.
    size_t stride = 1;
    for (size_t a = 0; a < 3; ++a) {
      const auto count = static_cast<size_t>(grid.dims[a]);
      around = sum;
      for (size_t n = 0; n < slots; ++n) {
        const size_t at = n / stride % count;
        if (at > 0) widen(around[n], sum[n - stride]);
        if (at + 1 < count) widen(around[n], sum[n + stride]);
      }
      std::swap(sum, around);
      stride *= count;
    }
    for (const SheetShare& share : m.shares)
      for (size_t n = 0; n < slots; ++n) widen(reach[share.source][n], sum[n]);
  }
  for (size_t i = 0; i < trail.sources.size(); ++i) {
    SplatPoints& points = trail.sources[i].points;
    points.codes.clear(); // of a layer alone
    for (size_t n = 0; n < points.bricks.size(); ++n) {
      SplatBrick& b = points.bricks[n];
      const Range& r = reach[i][brick_slot(grid, b)];
      b.reach[0] = r[0], b.reach[1] = r[1];
      // Cells are known no better than their brick: a layer alone tells nothing of a sum.
      for (auto& cells : points.cells)
        std::fill_n(cells.begin() + static_cast<std::ptrdiff_t>(n * cells_per_brick), cells_per_brick,
                    CellRange{r[0], r[1]});
    }
  }
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
  const Lattice4& lattice = coefficients.source().lattice();
  std::vector<std::vector<LayerWeight>> weights;
  std::vector<int32_t> wanted;
  for (const Moment& m : moments) {
    weights.push_back(instant_weights(lattice, coefficients.kernel(), m.at));
    for (const LayerWeight& w : weights.back()) wanted.push_back(w.layer);
  }
  std::sort(wanted.begin(), wanted.end());
  wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
  // A layer holds one coset's points, a still all of them, but of a still more is known to be invisible
  // (tests/bench/notes/trail.md).
  if (5 * wanted.size() >= 2 * moments.size() * static_cast<size_t>(lattice.space.cosets())) return false;
  const auto layers = coefficients.layers(wanted, context);
  for (const auto& layer : layers)
    if (has_holes(*layer)) return false;

  std::map<int32_t, uint32_t> source;
  std::map<const BrickLayer*, uint32_t> known; // mirror images beyond the ends are the same layer
  for (size_t i = 0; i < wanted.size(); ++i) {
    const auto [at, is_new] = known.try_emplace(layers[i].get(), static_cast<uint32_t>(trail.sources.size()));
    source[wanted[i]] = at->second;
    if (!is_new) continue;
    Slice slice = like;
    const int coset = lattice.coset(wanted[i]);
    slice.coset[static_cast<size_t>(coset)] = *layers[i];
    if (lattice.space.cosets() > 1)
      slice.coset[static_cast<size_t>(1 - coset)] = BrickLayer(lattice.space, 1 - coset);
    slice.has_holes = false;
    add_source(trail, std::move(slice), context);
  }
  double gain = 0; // of weights; none is negative
  for (size_t n = 0; n < moments.size(); ++n) {
    TrailMoment m{{}, moments[n].at, moments[n].weight, moments[n].interval};
    std::array<double, 2> sum{};
    for (const LayerWeight& w : weights[n]) {
      sum[static_cast<size_t>(lattice.coset(w.layer))] += static_cast<double>(w.weight);
      const uint32_t s = source[w.layer];
      const auto same =
          std::find_if(m.shares.begin(), m.shares.end(), [&](const SheetShare& x) { return x.source == s; });
      if (same != m.shares.end())
        same->weight += w.weight;
      else
        m.shares.push_back({s, w.weight});
    }
    gain = std::max({gain, sum[0], sum[1]});
    trail.moments.push_back(std::move(m));
  }
  bound_bricks(trail, static_cast<float>(gain));
  return true;
}

} // namespace bccsplat
