#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "slice/footprint.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>

#include "slice/dense_sites.h"
#include "slice/footprint.h"
#include "slice/patch_sum-inl.h"

#ifndef BCCSPLAT_FOOTPRINT_SHARED
#define BCCSPLAT_FOOTPRINT_SHARED
namespace bccsplat {

inline constexpr size_t footprint_batch = 512;

// Weights of layers in time, and their slopes per pitch, from the kernel itself: any shape, normalised or
// not.
void weigh_by_kernel(const FootprintPlan& plan, float from, std::array<float, max_stack>& w,
                     std::array<float, max_stack>& dw);
// Divides a value by the lattice sum at p, and corrects its gradient.
void divide_by_lattice_sum(const FootprintPlan& plan, const Vec4& p, float& value,
                           std::array<float, 4>* gradient);

} // namespace bccsplat
#endif

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
namespace {

// The bricks of a patch that lies in several: per piece, layer of the stack and quarter of the (y, z) plane.
using Bricks = std::array<std::array<std::array<const float*, 4>, max_stack>, 2>;

// A patch with mirror images along x: its sites, weighted in time, are copied to rows of their own.
template<int edge, bool slopes, bool contact>
HWY_INLINE Sums<slopes> SumFolded(const FootprintPlan& plan, const Curve<contact>& curve,
                                  const Bricks& bricks, const Stack& stack, const PatchPlace& place,
                                  const Place& p) {
  alignas(64) std::array<float, patch_sites> value, rate; // rate: weighted by the temporal slopes
  for (size_t z = 0; z < edge; ++z)
    for (size_t y = 0; y < edge; ++y) {
      Row sum, rate_sum;
      for (size_t k = 0; k < static_cast<size_t>(stack.count); ++k) {
        alignas(16) std::array<float, patch_edge> sites;
        for (size_t x = 0; x < patch_edge; ++x)
          sites[x] = bricks[static_cast<size_t>(place.x.half[x])][k][place.quarter(y, z)]
                           [place.row(y, z) + place.x.site[x]];
        const Row row = LoadRow(sites.data()), w = SetRow(stack.weight[k]);
        sum = k == 0 ? Times(w, row) : TimesPlus(w, row, sum);
        if (!slopes) continue;
        const Row dw = SetRow(stack.slope[k]);
        rate_sum = k == 0 ? Times(dw, row) : TimesPlus(dw, row, rate_sum);
      }
      const size_t at = patch_edge * (patch_edge * z + y);
      StoreRow(sum, value.data() + at);
      if (slopes) StoreRow(rate_sum, rate.data() + at);
    }
  Weights weights;
  Weigh<edge, slopes>(plan, curve, p, weights);
  const auto row_in = [](const std::array<float, patch_sites>& rows) {
    return [&rows](size_t, size_t y, size_t z) { return rows.data() + patch_edge * (patch_edge * z + y); };
  };
  const auto sums = AddPatch<edge, 1, slopes>({1, {}, {1}, {0}}, row_in(value), weights, p, NoSums<slopes>());
  if (!slopes) return sums;
  return AddPatch<edge, 1, slopes>({1, {}, {0}, {1}}, row_in(rate), weights, p, sums);
}

// A patch where bricks or mirrors meet.
template<int edge, bool slopes, bool contact>
HWY_NOINLINE Sums<slopes> SumPlaced(const FootprintPlan& plan, const FootprintPlan::Coset& coset,
                                    int first_layer, const std::array<float, max_stack>& time,
                                    const std::array<float, max_stack>& dtime, const PatchSpan& span,
                                    Place p) {
  const PatchPlace place = place_patch(*coset.layer[0], edge, span);
  const Curve<contact> curve(plan);
  Stack stack;
  Bricks bricks;
  for (int k = 0; k < plan.depth; ++k) {
    const auto at = static_cast<size_t>(first_layer + k); // wraps round below 0
    if (at >= coset.bricks.size()) continue;
    const auto s = static_cast<size_t>(stack.count);
    bool any = false;
    for (size_t piece = 0; piece < static_cast<size_t>(place.x.bricks); ++piece) {
      const auto* shares = coset.bricks[at] + place.slot[piece];
      for (size_t q = 0; q < 4; ++q) {
        const Brick* brick = shares[place.quarter_slots[q]].get();
        any = any || brick;
        bricks[piece][s][q] = brick ? brick->value.data() : air_brick();
      }
    }
    if (!any) continue;
    stack.weight[s] = time[static_cast<size_t>(k)];
    stack.slope[s] = dtime[static_cast<size_t>(k)];
    ++stack.count;
  }
  auto sums = NoSums<slopes>();
  if (stack.count == 0) return sums;
  if (place.folded) return SumFolded<edge, slopes>(plan, curve, bricks, stack, place, p);
  for (size_t piece = 0; piece < static_cast<size_t>(place.x.bricks); ++piece) {
    const int lane0 = (place.x.low + static_cast<int>(piece)) * brick_edge + place.lane0[piece];
    p.shift[0] = static_cast<float>(span.first[0] - lane0);
    Weights weights;
    Weigh<edge, slopes>(plan, curve, p, weights);
    const auto row_of = [&](size_t k, size_t y, size_t z) {
      return bricks[piece][k][place.quarter(y, z)] + place.row(y, z) + place.lane0[piece];
    };
    sums = AddStack<edge, slopes>(stack, row_of, weights, p, sums);
  }
  return sums;
}

// Per batch: where each point's patch begins, and how far from its first site the point lies; per axis x, y,
// z, t, in pitches. `last`, where the patch ends, is filled in only for points that look sites up in bricks.
struct Spans {
  alignas(64) std::array<int32_t, 4 * footprint_batch> first, last;
  alignas(64) std::array<float, 4 * footprint_batch> from;
  SiteBox box;   // of all patches
  bool one_time; // all points stand at one instant
};

void FindSpans(const FootprintPlan& plan, const FootprintPlan::Coset& coset, std::span<const Vec4> points,
               Spans& spans) {
  const hn::CappedTag<double, 4> d;
  const hn::Rebind<int32_t, decltype(d)> di;
  const hn::Rebind<float, decltype(d)> df;
  alignas(32) Vec4 low, high, start, end; // of the first sites; of the points
  for (size_t k = 0; k < 4; k += hn::Lanes(d)) {
    const auto one = hn::Set(d, 1.0), radius = hn::Load(d, plan.radius.data() + k);
    const auto per_pitch = hn::Load(d, plan.per_pitch.data() + k),
               origin = hn::Load(d, coset.origin.data() + k);
    auto least = hn::Set(d, 1e30), most = hn::Neg(least), before = least, after = most;
    for (size_t n = 0; n < points.size(); ++n) {
      const auto x = hn::MulAdd(hn::LoadU(d, points[n].data() + k), per_pitch, origin);
      const auto first = hn::Add(hn::Floor(hn::Sub(x, radius)), one);
      least = hn::Min(least, first), most = hn::Max(most, first);
      before = hn::Min(before, x), after = hn::Max(after, x);
      hn::Store(hn::DemoteTo(di, first), di, spans.first.data() + 4 * n + k);
      hn::Store(hn::DemoteTo(df, hn::Sub(x, first)), df, spans.from.data() + 4 * n + k);
    }
    hn::Store(least, d, low.data() + k), hn::Store(most, d, high.data() + k);
    hn::Store(before, d, start.data() + k), hn::Store(after, d, end.data() + k);
  }
  for (size_t a = 0; a < 3; ++a) {
    spans.box.origin[a] = static_cast<int32_t>(low[a]);
    spans.box.size[a] = static_cast<int32_t>(high[a] - low[a]) + (a == 0 ? patch_edge : plan.edge);
  }
  spans.one_time = start[3] == end[3];
}

void FindLast(const FootprintPlan& plan, const FootprintPlan::Coset& coset, std::span<const Vec4> points,
              Spans& spans) {
  const hn::CappedTag<double, 4> d;
  const hn::Rebind<int32_t, decltype(d)> di;
  const auto one = hn::Set(d, 1.0);
  for (size_t k = 0; k < 4; k += hn::Lanes(d)) {
    const auto radius = hn::Load(d, plan.radius.data() + k);
    const auto per_pitch = hn::Load(d, plan.per_pitch.data() + k),
               origin = hn::Load(d, coset.origin.data() + k);
    for (size_t n = 0; n < points.size(); ++n) {
      const auto x = hn::MulAdd(hn::LoadU(d, points[n].data() + k), per_pitch, origin);
      const auto last = hn::Sub(hn::Ceil(hn::Add(x, radius)), one);
      hn::Store(hn::DemoteTo(di, last), di, spans.last.data() + 4 * n + k);
    }
  }
}

template<bool slopes>
HWY_INLINE void WeighLayers(const FootprintPlan& plan, float from, std::array<float, max_stack>& w,
                            std::array<float, max_stack>& dw) {
  if (plan.timeless || plan.kernel->time.shape == TemporalKernel::Shape::bspline)
    WeighSpline<slopes>(plan.depth, from, w, dw);
  else
    weigh_by_kernel(plan, from, w, dw);
}

// One coset's part of the sums at a point: first, last and from as in Spans.
template<int edge, bool slopes, bool contact>
HWY_INLINE Sums<slopes> SumCoset(const FootprintPlan& plan, const Curve<contact>& curve,
                                 const FootprintPlan::Coset& coset, const int32_t* first, const int32_t* last,
                                 const float* from) {
  std::array<float, max_stack> time, dtime;
  WeighLayers<slopes>(plan, from[3], time, dtime);
  const PatchSpan span{{first[0], first[1], first[2]}, {last[0], last[1], last[2]}};
  Place p{{from[0], from[1], from[2]}};
  const int first_layer = plan.timeless ? 0 : first[3];
  PatchCorner corner;
  if (!patch_in_one_brick(coset.dims, coset.brick_dims, edge, span, corner))
    return SumPlaced<edge, slopes, contact>(plan, coset, first_layer, time, dtime, span, p);
  Stack stack;
  for (int k = 0; k < plan.depth; ++k) {
    const auto layer = static_cast<size_t>(first_layer + k); // wraps round below 0
    if (layer >= coset.bricks.size()) continue;
    const Brick* brick = coset.bricks[layer][corner.slot].get();
    if (!brick) continue;
    const auto s = static_cast<size_t>(stack.count++);
    stack.corner[s] = brick->value.data() + corner.offset;
    stack.weight[s] = time[static_cast<size_t>(k)];
    stack.slope[s] = dtime[static_cast<size_t>(k)];
  }
  if (stack.count == 0) return NoSums<slopes>();
  for (size_t a = 0; a < 3; ++a) p.shift[a] = static_cast<float>(span.first[a] - corner.start[a]);
  Weights weights;
  Weigh<edge, slopes>(plan, curve, p, weights);
  const auto row_of = [&stack](size_t k, size_t y, size_t z) {
    return stack.corner[k] + (z * brick_edge + y) * brick_edge;
  };
  return AddStack<edge, slopes>(stack, row_of, weights, p, NoSums<slopes>());
}

// The same from a dense copy of the sites around a batch.
template<int edge, bool slopes, bool contact>
HWY_INLINE Sums<slopes> SumDense(const FootprintPlan& plan, const Curve<contact>& curve,
                                 const DenseSites& sites, const int32_t* first, const float* from) {
  if (sites.layers == 0) return NoSums<slopes>();
  Stack stack;
  const float* corner = sites.value + sites.offset({first[0], first[1], first[2]});
  if (sites.merged) {
    stack.count = 1;
    stack.weight[0] = 1, stack.slope[0] = 0;
    stack.corner[0] = corner;
  } else {
    std::array<float, max_stack> time, dtime;
    WeighLayers<slopes>(plan, from[3], time, dtime);
    for (int k = 0; k < plan.depth; ++k) {
      const auto layer = static_cast<size_t>(first[3] + k); // wraps round below 0
      if (layer >= sites.layers) continue;
      const auto s = static_cast<size_t>(stack.count++);
      stack.corner[s] = corner + layer * sites.layer;
      stack.weight[s] = time[static_cast<size_t>(k)];
      stack.slope[s] = dtime[static_cast<size_t>(k)];
    }
    if (stack.count == 0) return NoSums<slopes>();
  }
  const Place p{{from[0], from[1], from[2]}};
  Weights weights;
  Weigh<edge, slopes>(plan, curve, p, weights);
  const auto row_of = [&](size_t k, size_t y, size_t z) {
    return stack.corner[k] + (z * sites.plane + y * sites.row);
  };
  if (!sites.merged) return AddStack<edge, slopes>(stack, row_of, weights, p, NoSums<slopes>());
  auto sums = AddPatch<edge, 1, slopes, false>(stack, row_of, weights, p, NoSums<slopes>());
  if constexpr (slopes) {
    const auto rate_of = [&](size_t, size_t y, size_t z) {
      return stack.corner[0] + (sites.layer + z * sites.plane + y * sites.row);
    };
    if (!plan.timeless)
      sums.time = AddPatch<edge, 1, false, false>(stack, rate_of, weights, p, NoSums<false>()).value;
  }
  return sums;
}

// to = w * from, or to += w * from.
void AddScaled(float w, const float* from, float* to, size_t count, bool add) {
  const hn::ScalableTag<float> d;
  const auto v = hn::Set(d, w);
  for (size_t i = 0; i < count; i += hn::Lanes(d)) { // layers are whole vectors
    const auto x = hn::LoadU(d, from + i);
    hn::StoreU(add ? hn::MulAdd(v, x, hn::LoadU(d, to + i)) : hn::Mul(v, x), d, to + i);
  }
}

// Copies the sites a batch needs where that is cheap against evaluating it from bricks; else leaves them.
template<bool slopes>
bool CopySites(const FootprintPlan& plan, const std::array<Spans, 2>& spans, size_t points,
               DenseScratch& scratch) {
  const std::array<SiteBox, 2> box{spans[0].box, spans[plan.cosets == 2 ? 1 : 0].box};
  const bool one_time = spans[0].one_time;
  if (!scratch.reserve(plan, box, points, one_time, slopes)) return false;
  for (int c = 0; c < plan.cosets; ++c) {
    const auto& coset = plan.coset[static_cast<size_t>(c)];
    const Spans& s = spans[static_cast<size_t>(c)];
    DenseSites& sites = scratch.sites[static_cast<size_t>(c)];
    if (!one_time) {
      bool any = false;
      for (const BrickLayer* layer : coset.layer)
        any = gather_box(*layer, sites.box, sites.value + sites.layer * sites.layers++) || any;
      if (!any) sites.layers = 0;
      continue;
    }
    std::array<float, max_stack> time, dtime;
    WeighLayers<slopes>(plan, s.from[3], time, dtime);
    for (int k = 0; k < plan.depth; ++k) {
      const auto layer = static_cast<size_t>((plan.timeless ? 0 : s.first[3]) + k); // wraps round below 0
      if (layer >= coset.layer.size()) continue;
      // Layers that are air add nothing.
      if (!gather_box(*coset.layer[layer], sites.box, scratch.single)) continue;
      const auto w = static_cast<size_t>(k);
      AddScaled(time[w], scratch.single, sites.value, sites.layer, sites.layers > 0);
      if (slopes && !plan.timeless)
        AddScaled(dtime[w], scratch.single, sites.value + sites.layer, sites.layer, sites.layers > 0);
      ++sites.layers;
    }
  }
  return true;
}

template<int edge, bool slopes, bool dense, bool contact>
HWY_INLINE Sums<slopes> SumsOf(const FootprintPlan& plan, const Curve<contact>& curve,
                               const DenseScratch& scratch, const Spans& spans, size_t c, size_t n) {
  const int32_t *first = spans.first.data() + 4 * n, *last = spans.last.data() + 4 * n;
  const float* from = spans.from.data() + 4 * n;
  if constexpr (dense)
    return SumDense<edge, slopes>(plan, curve, scratch.sites[c], first, from);
  else
    return SumCoset<edge, slopes>(plan, curve, plan.coset[c], first, last, from);
}

template<int edge, bool slopes, bool contact, bool dense>
void SumBatch(const FootprintPlan& plan, const DenseScratch& scratch, const std::array<Spans, 2>& spans,
              std::span<const Vec4> points, float* values, std::array<float, 4>* gradients) {
  const Curve<contact> curve(plan);
  for (size_t n = 0; n < points.size(); ++n) {
    const auto even = SumsOf<edge, slopes, dense>(plan, curve, scratch, spans[0], 0, n);
    auto odd = NoSums<slopes>();
    if (plan.cosets == 2) odd = SumsOf<edge, slopes, dense>(plan, curve, scratch, spans[1], 1, n);
    values[n] = Total(even.value, odd.value);
    if constexpr (slopes) {
      const auto per = static_cast<float>(plan.per_pitch[0]),
                 per_time = static_cast<float>(plan.per_pitch[3]);
      gradients[n] = {2 * per * Total(even.x, odd.x), 2 * per * Total(even.y, odd.y),
                      2 * per * Total(even.z, odd.z), per_time * Total(even.time, odd.time)};
    }
    if (plan.kernel->normalised)
      divide_by_lattice_sum(plan, points[n], values[n], slopes ? &gradients[n] : nullptr);
  }
}

template<int edge, bool slopes, bool contact>
void SumBatches(const FootprintPlan& plan, std::span<const Vec4> points, float* values,
                std::array<float, 4>* gradients) {
  std::array<Spans, 2> spans;
  DenseScratch scratch;
  for (size_t begin = 0; begin < points.size(); begin += footprint_batch) {
    const auto batch = points.subspan(begin, std::min(footprint_batch, points.size() - begin));
    for (int c = 0; c < plan.cosets; ++c)
      FindSpans(plan, plan.coset[static_cast<size_t>(c)], batch, spans[static_cast<size_t>(c)]);
    const bool dense = CopySites<slopes>(plan, spans, batch.size(), scratch);
    for (int c = 0; c < (dense ? 0 : plan.cosets); ++c)
      FindLast(plan, plan.coset[static_cast<size_t>(c)], batch, spans[static_cast<size_t>(c)]);
    const auto sum = dense ? SumBatch<edge, slopes, contact, true> : SumBatch<edge, slopes, contact, false>;
    sum(plan, scratch, spans, batch, values + begin, slopes ? gradients + begin : nullptr);
  }
}

} // namespace

void SumFootprints(const FootprintPlan& plan, std::span<const Vec4> points, float* values,
                   std::array<float, 4>* gradients) {
  const auto choose = [&]<int edge>(std::integral_constant<int, edge>) {
    if (plan.contact) return gradients ? SumBatches<edge, true, true> : SumBatches<edge, false, true>;
    return gradients ? SumBatches<edge, true, false> : SumBatches<edge, false, false>;
  };
  const auto sum =
      plan.edge == 3 ? choose(std::integral_constant<int, 3>()) : choose(std::integral_constant<int, 4>());
  sum(plan, points, values, gradients);
}

} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <numbers>

#include "kernel/cc_kernel.h"
#include "slice/kernel_time.h"

namespace bccsplat {
HWY_EXPORT(SumFootprints);

void divide_by_lattice_sum(const FootprintPlan& plan, const Vec4& p, float& value,
                           std::array<float, 4>* gradient) {
  const auto sum_at = [&](const Vec4& q) { return lattice_sum(*plan.kernel, plan.bcc, q[0], q[1], q[2]); };
  const double total = sum_at(p);
  value = static_cast<float>(static_cast<double>(value) / total);
  if (!gradient) return;
  for (size_t i = 0; i < 4; ++i) {
    float& g = (*gradient)[i];
    double slope = 0;
    if (i < 3) { // smooth and known in closed form: central differences are enough
      constexpr double h = 1e-4;
      Vec4 low = p, high = p;
      low[i] -= h, high[i] += h;
      slope = (sum_at(high) - sum_at(low)) / (2 * h);
    }
    g = static_cast<float>((static_cast<double>(g) - static_cast<double>(value) * slope) / total);
  }
}

void weigh_by_kernel(const FootprintPlan& plan, float from, std::array<float, max_stack>& w,
                     std::array<float, max_stack>& dw) {
  constexpr double pitch = std::numbers::sqrt2; // of kernel time
  double sum = 0, slope_sum = 0;
  std::array<double, max_stack> value, slope;
  const auto depth = static_cast<size_t>(plan.depth);
  for (size_t k = 0; k < depth; ++k) {
    const double dt = pitch * (static_cast<double>(from) - static_cast<double>(k));
    value[k] = plan.kernel->time.value(dt), slope[k] = pitch * plan.kernel->time.slope(dt);
    sum += value[k], slope_sum += slope[k];
  }
  const bool divide = plan.kernel->normalised && sum > 0;
  for (size_t k = 0; k < depth; ++k) {
    if (divide) value[k] /= sum, slope[k] = slope[k] / sum - value[k] * slope_sum / sum;
    w[k] = static_cast<float>(value[k]), dw[k] = static_cast<float>(slope[k]);
  }
}

FootprintPlan::FootprintPlan(const FieldLayers& field) : kernel(field.kernel), timeless(field.timeless) {
  constexpr double time_pitch = std::numbers::sqrt2; // of kernel time
  const Lattice3& lattice = field.layers[0].layer->lattice();
  bcc = lattice.bcc;
  cosets = lattice.cosets();
  const double pitch = coset_pitch(lattice);
  for (size_t i = 0; i < 3; ++i) per_pitch[i] = 1 / pitch, radius[i] = kernel->space.radius / pitch;
  per_pitch[3] = timeless ? 0 : 1 / time_pitch;
  radius[3] = timeless ? 0 : time_reach(*kernel) / time_pitch;
  edge = 2 * radius[0] <= 3 ? 3 : 4;
  if (!timeless) depth = static_cast<int>(std::ceil(2 * radius[3]));
  inverse_radius2 = static_cast<float>(1 / (radius[0] * radius[0]));
  terms = kernel->space.terms;
  for (size_t j = 0; j < a.size(); ++j) a[j] = static_cast<float>(kernel->space.a[j]);
  contact = terms == 8 && a[0] == 0 && a[1] == 0;
  for (int i = 0; i < patch_rows; ++i)
    lane_x[static_cast<size_t>(i)] = static_cast<float>(i % patch_edge),
    lane_y[static_cast<size_t>(i)] = static_cast<float>(i / patch_edge);
  for (const FieldLayer& l : field.layers) {
    const auto c = static_cast<size_t>(l.layer->coset());
    Coset& to = coset[c];
    if (to.layer.empty()) {
      to.dims = l.layer->dims(), to.brick_dims = l.layer->brick_dims();
      for (size_t i = 0; i < 3; ++i) to.origin[i] = -0.5 * static_cast<double>(c);
      to.origin[3] = timeless ? 0 : -l.time / time_pitch;
    }
    to.layer.push_back(l.layer);
    to.bricks.push_back(&l.layer->share(0));
  }
}

void sum_footprints(const FootprintPlan& plan, std::span<const Vec4> points, float* values,
                    std::array<float, 4>* gradients) {
  HWY_DYNAMIC_DISPATCH(SumFootprints)(plan, points, values, gradients);
}

void sum_footprints(const FieldLayers& field, std::span<const Vec4> points, float* values,
                    std::array<float, 4>* gradients) {
  sum_footprints(FootprintPlan(field), points, values, gradients);
}

} // namespace bccsplat
#endif
