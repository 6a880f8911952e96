#include "slice/evaluate.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "slice/footprint.h"
#include "slice/hole.h"

namespace bccsplat {
namespace {

constexpr float nan_value = std::numeric_limits<float>::quiet_NaN();
constexpr size_t block = 256; // points handed to the inner loop at a time

// The coefficient layers that instants between `base` and `base + 1` (in layers) need.
struct Window {
  std::vector<std::shared_ptr<const BrickLayer>> held;
  std::vector<FieldLayer> layers;
  bool holes = false;

  Window(const Coefficients& coefficients, int32_t base, const Context& context) {
    const Lattice4& lattice = coefficients.source().lattice();
    if (lattice.is_static()) {
      add(coefficients, 0, 0, context), add(coefficients, 1, 0, context);
    } else {
      const double reach = coefficients.kernel().time.half_width / lattice.layer_distance();
      const auto first = static_cast<int32_t>(std::ceil(base - reach)),
                 last = static_cast<int32_t>(std::floor(base + 1 + reach));
      for (int32_t m = first; m <= last; ++m) add(coefficients, m, m * lattice.layer_distance(), context);
    }
    for (const auto& layer : held)
      for (size_t s = 0; s < layer->brick_slots() && !holes; ++s)
        holes = layer->brick(s) && layer->brick(s)->hole;
  }

  // As in a time slice: of each coset the layer nearest in time decides.
  [[nodiscard]] bool is_hole(const Vec3& p, double time) const {
    std::array<const FieldLayer*, 2> nearest{};
    for (const FieldLayer& l : layers) {
      auto& best = nearest[static_cast<size_t>(l.layer->coset())];
      if (!best || std::fabs(l.time - time) < std::fabs(best->time - time)) best = &l;
    }
    return is_hole_at({nearest[0] ? nearest[0]->layer : nullptr, nearest[1] ? nearest[1]->layer : nullptr},
                      p);
  }

 private:
  void add(const Coefficients& coefficients, int32_t m, double time, const Context& context) {
    held.push_back(coefficients.layer(m, context));
    layers.push_back({held.back().get(), time});
  }
};

} // namespace

EvaluateMisses evaluate(const Slice& slice, std::span<const Vec3> points, std::span<float> values,
                        std::span<std::array<float, 3>> gradients) {
  EvaluateMisses misses;
  const std::array<FieldLayer, 2> layers{FieldLayer{&slice.coset[0]}, FieldLayer{&slice.coset[1]}};
  const FieldLayers field{std::span(layers).first(static_cast<size_t>(slice.lattice.cosets())),
                          &slice.kernel};
  std::array<Vec4, block> batch;
  std::array<size_t, block> where;
  std::array<float, block> sums;
  std::array<std::array<float, 4>, block> slopes;
  size_t count = 0;
  const auto flush = [&] {
    sum_footprints(field, std::span(batch).first(count), sums.data(),
                   gradients.empty() ? nullptr : slopes.data());
    for (size_t i = 0; i < count; ++i) {
      values[where[i]] = slice.air + sums[i];
      if (!gradients.empty()) gradients[where[i]] = {slopes[i][0], slopes[i][1], slopes[i][2]};
    }
    count = 0;
  };
  for (size_t n = 0; n < points.size(); ++n) {
    const Vec3& p = points[n];
    const bool outside = !slice.inside(p);
    if (outside || slice.is_hole(p)) {
      ++(outside ? misses.outside : misses.holes);
      values[n] = nan_value;
      if (!gradients.empty()) gradients[n] = {nan_value, nan_value, nan_value};
      continue;
    }
    batch[count] = {p[0], p[1], p[2], 0};
    where[count] = n;
    if (++count == block) flush();
  }
  flush();
  return misses;
}

void evaluate4_mirrored(const Coefficients& coefficients, std::span<const Vec4> points,
                        std::span<float> values, std::span<std::array<float, 4>> gradients,
                        std::span<uint8_t> holes, const Context& context) {
  const Lattice4& lattice = coefficients.source().lattice();
  const Vec3 unit = lattice.lattice_unit();
  const double time_unit = lattice.is_static() ? 1 : lattice.time_step / lattice.layer_distance();
  const auto window_of = [&](const Vec4& p) {
    return lattice.is_static() ? 0 : static_cast<int32_t>(std::floor(p[3] / lattice.time_step));
  };
  // Points of one stretch between two layers share their window of coefficients.
  std::vector<uint64_t> order(points.size());
  std::iota(order.begin(), order.end(), uint64_t{0});
  const auto earlier = [&](uint64_t a, uint64_t b) { return window_of(points[a]) < window_of(points[b]); };
  if (!std::is_sorted(order.begin(), order.end(), earlier))
    std::stable_sort(order.begin(), order.end(), earlier);
  for (size_t begin = 0; begin < order.size();) {
    const int32_t base = window_of(points[order[begin]]);
    size_t end = begin;
    while (end < order.size() && window_of(points[order[end]]) == base) ++end;
    const Window window(coefficients, base, context);
    const FieldLayers field{window.layers, &coefficients.kernel(), lattice.is_static()};
    context.tasks.parallel_for((end - begin + block - 1) / block, [&](uint64_t b) {
      context.progress.check();
      std::array<Vec4, block> batch;
      std::array<float, block> sums;
      std::array<std::array<float, 4>, block> slopes;
      const size_t from = begin + b * block, count = std::min(block, end - from);
      for (size_t i = 0; i < count; ++i) {
        const Vec4& p = points[order[from + i]];
        batch[i] = {p[0] / unit[0], p[1] / unit[1], p[2] / unit[2], p[3] / time_unit};
      }
      sum_footprints(field, std::span(batch).first(count), sums.data(),
                     gradients.empty() ? nullptr : slopes.data());
      for (size_t i = 0; i < count; ++i) {
        const uint64_t n = order[from + i];
        values[n] = sums[i];
        if (!gradients.empty())
          gradients[n] = {
              static_cast<float>(slopes[i][0] / unit[0]), static_cast<float>(slopes[i][1] / unit[1]),
              static_cast<float>(slopes[i][2] / unit[2]), static_cast<float>(slopes[i][3] / time_unit)};
        if (!holes.empty())
          holes[n] = window.holes && window.is_hole({batch[i][0], batch[i][1], batch[i][2]}, batch[i][3]);
      }
    });
    begin = end;
  }
}

EvaluateMisses evaluate4(const Coefficients& coefficients, std::span<const Vec4> points,
                         std::span<float> values, std::span<std::array<float, 4>> gradients,
                         const Context& context) {
  const Lattice4& lattice = coefficients.source().lattice();
  const size_t axes = lattice.is_static() ? 3 : 4;
  const auto inside = [&](const Vec4& p) {
    for (size_t a = 0; a < axes; ++a)
      if (!(p[a] >= 0 && p[a] <= lattice.dims[a] - 1.0)) return false;
    return true;
  };
  // Most batches lie inside as a whole; a point outside is evaluated at the domain's corner and then
  // overwritten.
  EvaluateMisses misses;
  std::vector<Vec4> moved;
  for (size_t n = 0; n < points.size(); ++n)
    if (!inside(points[n])) {
      if (moved.empty()) moved.assign(points.begin(), points.end());
      moved[n] = {};
      ++misses.outside;
    }
  std::vector<uint8_t> holes(points.size());
  evaluate4_mirrored(coefficients, moved.empty() ? points : std::span<const Vec4>(moved), values, gradients,
                     holes, context);
  for (size_t n = 0; n < points.size(); ++n) {
    const bool outside = misses.outside > 0 && !inside(points[n]);
    if (!outside) values[n] += coefficients.air();
    if (!outside && !holes[n]) continue;
    misses.holes += !outside;
    values[n] = nan_value;
    if (!gradients.empty()) gradients[n].fill(nan_value);
  }
  return misses;
}

} // namespace bccsplat
