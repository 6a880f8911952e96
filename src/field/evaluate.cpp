// SPDX-License-Identifier: Apache-2.0
// Evaluates slices and volumes at arbitrary points: points are ordered by what they share, handed to the
// inner loop in blocks, and marked where they lie outside or in holes.
#include "field/evaluate.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "base/would_block.h"
#include "field/corrections.h"
#include "field/footprint/footprint.h"
#include "field/footprint/hole.h"
#include "field/masks.h"
#include "field/point_axes.h"
#include "field/point_order.h"
#include "kernel/kernel_time.h"

namespace bccsplat {
namespace {

constexpr float no_value = std::numeric_limits<float>::quiet_NaN();
constexpr size_t batch_points = 512; // points handed to the inner loop at a time: one of its batches

struct HeldLayer {
  std::shared_ptr<const BrickLayer> layer;
  bool holes = false;
};
using HeldLayers = std::map<int32_t, HeldLayer>;

// Returns the layers, first and last, of the windows from base0 to base1.
std::array<int32_t, 2> window_layers(const Lattice4& lattice, const Kernel& kernel, int32_t base0,
                                     int32_t base1) {
  if (lattice.is_static()) return {0, lattice.last_layer};
  const double reach = time_reach(kernel) / kernel_time_per_layer(lattice);
  return {static_cast<int32_t>(std::ceil(base0 - reach)) + lattice.lead,
          static_cast<int32_t>(std::floor(base1 + 1 + reach)) + lattice.lead};
}

// The coefficient layers that instants between layers `base` and `base + 1` from frame 0 need.
struct Window {
  std::vector<FieldLayer> layers;
  bool holes = false;

  // `held` keeps the layers alive, and for the next window those it shares with this one.
  Window(const Coefficients& coefficients, int32_t base, HeldLayers& held, const Context& context) {
    const Lattice4& lattice = coefficients.source().lattice();
    const auto [first, last] = window_layers(lattice, coefficients.kernel(), base, base);
    held.erase(held.begin(), held.lower_bound(first));
    std::vector<int32_t> wanted;
    for (int32_t m = first; m <= last; ++m)
      if (!held.contains(m)) wanted.push_back(m);
    const auto made = coefficients.layers(wanted, context);
    for (size_t i = 0; i < wanted.size(); ++i) {
      HeldLayer& l = held[wanted[i]];
      l.layer = made[i];
      for (size_t s = 0; s < l.layer->brick_slots() && !l.holes; ++s)
        l.holes = l.layer->brick(s) && l.layer->brick(s)->hole;
    }
    for (const auto& [m, l] : held) {
      holes = holes || l.holes;
      layers.push_back({l.layer.get(), kernel_time_of_layer(lattice, m)});
    }
  }

  // The layer of each coset that is nearest in time decides, as it does in a time slice.
  [[nodiscard]] bool is_hole(const Vec4& p) const {
    std::array<const FieldLayer*, 2> nearest{};
    for (const FieldLayer& l : layers) {
      auto& best = nearest[l.layer->coset()];
      if (!best || std::fabs(l.time - p[3]) < std::fabs(best->time - p[3])) best = &l;
    }
    return is_hole_at({nearest[0] ? nearest[0]->layer : nullptr, nearest[1] ? nearest[1]->layer : nullptr},
                      {p[0], p[1], p[2]});
  }
};

// Values are relative to the base, and `offset` added. Where `clip` is set points outside the domain are NaN,
// and so are those in holes; else the field is mirrored there, and `holes` (may be empty) is filled in.
EvaluateMisses evaluate_points(const Coefficients& coefficients, std::span<const Vec4> points, bool clip,
                               float offset, std::span<float> values,
                               std::span<std::array<float, 4>> gradients, std::span<uint8_t> holes,
                               const Context& context) {
  const Lattice4& lattice = coefficients.source().lattice();
  const PointAxes axes(lattice, points.size());
  const PointOrder order = order_points(
      points.size(), axes.cell_count,
      [&](uint64_t begin, std::span<PointPlace> places) {
        axes.place(points.subspan(begin, places.size()), clip, places);
      },
      context);
  std::atomic<uint64_t> outside{0}, in_holes{0};
  std::fill(holes.begin(), holes.end(), uint8_t{0});
  HeldLayers held;
  Attempts attempts;
  std::array<float, 4> per_index;
  for (size_t a = 0; a < 4; ++a) per_index[a] = static_cast<float>(axes.scale[a]);
  for (const PointOrder::Group& group : order.groups) {
    const auto total = static_cast<double>(points.size()), begin = static_cast<double>(group.begin) / total,
               end = static_cast<double>(group.end) / total, middle = (begin + end) / 2;
    Progress making(context.progress, begin, middle), summing(context.progress, middle, end);
    std::optional<Window> made;
    attempts.attempt([&] { made.emplace(coefficients, group.window, held, context.with(making)); });
    if (attempts.waits()) continue;
    const Window& window = *made;
    const FootprintPlan plan({window.layers, &coefficients.kernel(), lattice.is_static()});
    const uint64_t blocks = (group.end - group.begin + batch_points - 1) / batch_points;
    std::atomic<uint64_t> done{0};
    context.tasks.parallel_for(blocks, [&](uint64_t b) {
      summing.advance(done.fetch_add(1, std::memory_order_relaxed), blocks);
      std::array<Vec4, batch_points> batch;
      std::array<float, batch_points> sums;
      std::array<std::array<float, 4>, batch_points> slopes;
      std::array<uint8_t, batch_points> none; // has no value
      const uint64_t from = group.begin + b * batch_points,
                     count = std::min<uint64_t>(batch_points, group.end - from);
      std::array<uint64_t, batch_points> at;
      const bool together = order.points_at(from, std::span(at).first(count));
      EvaluateMisses misses;
      misses.outside =
          axes.scale_points(points.data(), std::span(at).first(count), clip, batch.data(), none.data());
      float* const value = together ? values.data() + at[0] : sums.data();
      std::array<float, 4>* slope = nullptr;
      if (!gradients.empty()) slope = together ? gradients.data() + at[0] : slopes.data();
      sum_footprints(plan, std::span(batch).first(count), value, slope);
      if (window.holes)
        for (uint64_t i = 0; i < count; ++i) {
          const bool hole = !none[i] && window.is_hole(batch[i]);
          if (!holes.empty()) holes[at[i]] = hole;
          misses.holes += clip && hole;
          none[i] = none[i] || (clip && hole);
        }
      for (uint64_t i = 0; i < count; ++i) value[i] += offset;
      if (slope)
        for (uint64_t i = 0; i < count; ++i)
          for (size_t a = 0; a < 4; ++a) slope[i][a] *= per_index[a];
      if (misses.outside + misses.holes > 0)
        for (uint64_t i = 0; i < count; ++i) {
          if (!none[i]) continue;
          value[i] = no_value;
          if (slope) slope[i].fill(no_value);
        }
      if (!together) {
        for (uint64_t i = 0; i < count; ++i) values[at[i]] = sums[i];
        for (uint64_t i = 0; slope && i < count; ++i) gradients[at[i]] = slopes[i];
      }
      outside += misses.outside, in_holes += misses.holes;
    });
  }
  attempts.throw_if_waiting();
  return {outside, in_holes};
}

} // namespace

namespace {

// Adds a slice's corrections at a point, in lattice units; returns whether it is one that the file has in
// spite of a hole.
bool correct_point(const Slice& slice, const Vec3& p, float& value, std::array<float, 3>* gradient) {
  const Vec3 uvw = slice.lattice_to_slice.point(p);
  if (std::isnan(value)) {
    const float* set = slice.corrections->set_at(uvw);
    if (set) value = *set;
    return set != nullptr;
  }
  Vec3 slope;
  value += slice.corrections->at(uvw, gradient ? &slope : nullptr);
  if (!gradient) return false;
  slope = slice.lattice_to_slice.transposed(slope);
  for (size_t a = 0; a < 3; ++a) (*gradient)[a] += static_cast<float>(slope[a]);
  return false;
}

} // namespace

EvaluateMisses evaluate(const Slice& slice, std::span<const Vec3> points, std::span<float> values,
                        std::span<std::array<float, 3>> gradients) {
  EvaluateMisses misses;
  const std::array<FieldLayer, 2> layers{FieldLayer{&slice.coset[0]}, FieldLayer{&slice.coset[1]}};
  const FootprintPlan plan({std::span(layers).first(slice.lattice.cosets()), &slice.kernel});
  std::array<Vec4, batch_points> batch;
  std::array<float, batch_points> sums;
  std::array<std::array<float, 4>, batch_points> slopes;
  std::array<uint8_t, batch_points> none;
  for (size_t begin = 0; begin < points.size(); begin += batch_points) {
    const size_t count = std::min(batch_points, points.size() - begin);
    for (size_t i = 0; i < count; ++i) {
      const Vec3& p = points[begin + i];
      const bool outside = !slice.inside(p), hole = !outside && slice.is_hole(p);
      misses.outside += outside, misses.holes += hole;
      none[i] = outside || hole;
      batch[i] = outside ? Vec4{} : Vec4{p[0], p[1], p[2], 0};
    }
    sum_footprints(plan, std::span(batch).first(count), sums.data(),
                   gradients.empty() ? nullptr : slopes.data());
    for (size_t i = 0; i < count; ++i) {
      values[begin + i] = none[i] ? no_value : slice.base + sums[i];
      if (gradients.empty()) continue;
      for (size_t a = 0; a < 3; ++a) gradients[begin + i][a] = none[i] ? no_value : slopes[i][a];
    }
    for (size_t i = begin; slice.corrections && i < begin + count; ++i)
      misses.holes -= correct_point(slice, points[i], values[i], gradients.empty() ? nullptr : &gradients[i]);
  }
  return misses;
}

EvaluateMisses evaluate4(const Coefficients& coefficients, std::span<const Vec4> points,
                         std::span<float> values, std::span<std::array<float, 4>> gradients,
                         const Context& context) {
  EvaluateMisses misses;
  Attempts attempts;
  attempts.attempt([&] {
    misses = evaluate_points(coefficients, points, true, coefficients.base(), values, gradients, {}, context);
  });
  if (const Corrections* fix = coefficients.corrections(); fix && fix->any())
    attempts.attempt([&] { misses.holes -= fix->add_to_points(points, values, gradients, context); });
  if (const Masks* masks = coefficients.masks())
    attempts.attempt([&] { misses.holes += masks->hide(points, values, gradients, context); });
  attempts.throw_if_waiting();
  return misses;
}

void evaluate4_mirrored(const Coefficients& coefficients, std::span<const Vec4> points,
                        std::span<float> values, std::span<std::array<float, 4>> gradients,
                        std::span<uint8_t> holes, const Context& context) {
  evaluate_points(coefficients, points, false, 0, values, gradients, holes, context);
  if (const Corrections* fix = coefficients.corrections(); fix && fix->any())
    fix->add_to_points(points, values, gradients, context);
  if (const Masks* masks = coefficients.masks(); masks && !holes.empty()) masks->mark(points, holes, context);
}

std::array<int32_t, 2> layers_of_moments(const Lattice4& lattice, const Kernel& kernel, double t0,
                                         double t1) {
  const double per_frame = lattice.is_static() ? 0 : 1 / lattice.time_step;
  return window_layers(lattice, kernel, static_cast<int32_t>(std::floor(t0 * per_frame)),
                       static_cast<int32_t>(std::floor(t1 * per_frame)));
}

} // namespace bccsplat
