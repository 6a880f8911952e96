// SPDX-License-Identifier: Apache-2.0
// Merges coefficient layers into a time slice: one weight per layer, brick by brick.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "slice/time_slice.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>

#include "base/would_block.h"
#include "kernel/kernel_time.h"
#include "points/brick.h"
#include "slice/corrected_slice.h"
#include "slice/masked_slice.h"
#include "slice/maximum_slice.h"
#include "slice/time_slice.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
namespace {

// Sets a plane of a brick to sum_k weight[k] * plane[k], summed in the order given, and widens `range` by it.
void MergePlanes(const float* const* planes, const float* weights, size_t count, float* out, float* range) {
  const hn::ScalableTag<float> d;
  auto low = hn::Set(d, range[0]), high = hn::Set(d, range[1]);
  for (size_t i = 0; i < brick_rows; i += hn::Lanes(d)) {
    auto sum = hn::Mul(hn::Set(d, weights[0]), hn::Load(d, planes[0] + i));
    for (size_t k = 1; k < count; ++k)
      sum = hn::MulAdd(hn::Set(d, weights[k]), hn::Load(d, planes[k] + i), sum);
    hn::Store(sum, d, out + i);
    low = hn::Min(low, sum), high = hn::Max(high, sum);
  }
  range[0] = hn::GetLane(hn::MinOfLanes(d, low)), range[1] = hn::GetLane(hn::MaxOfLanes(d, high));
}

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {
HWY_EXPORT(MergePlanes);

namespace {

// Returns weight(kernel time of the layer) for all layers in [begin, end] +- half_width, kernel time, where
// it is not 0.
template<class Weight>
std::vector<LayerWeight> layer_weights(const Lattice4& lattice, const Kernel& kernel, double begin,
                                       double end, const Weight& weight) {
  const double distance = kernel_time_per_layer(lattice), reach = time_reach(kernel);
  const int32_t first = static_cast<int32_t>(std::ceil((begin - reach) / distance)) + lattice.lead;
  const int32_t last = static_cast<int32_t>(std::floor((end + reach) / distance)) + lattice.lead;
  std::vector<LayerWeight> result;
  std::array<double, 2> sum{};
  for (int32_t m = first; m <= last; ++m) {
    const double w = weight(kernel_time_of_layer(lattice, m));
    if (w == 0) continue;
    sum[lattice.coset(m)] += w;
    result.push_back({m, static_cast<float>(w)});
  }
  if (kernel.normalised)
    for (LayerWeight& l : result) l.weight = static_cast<float>(l.weight / sum[lattice.coset(l.layer)]);
  return result;
}

std::vector<LayerWeight> static_weights(const Lattice4& lattice) {
  std::vector<LayerWeight> result;
  for (int c = 0; c < lattice.space.cosets(); ++c) result.push_back({c, 1.0f});
  return result;
}

using Part = MomentPlan::Part;

// A brick of a part in one of two forms, or air.
struct PartBrick {
  const Brick* values = nullptr;
  const CodedBrick* codes = nullptr;
  float weight = 0;

  PartBrick(const Part& part, size_t slot) : weight(part.weight) {
    if (part.of.values) {
      values = part.of.values->brick(slot);
    } else {
      const SampleBrick& brick = part.of.compact->brick(slot);
      values = brick.values.get(), codes = brick.codes.get();
    }
  }
  explicit operator bool() const { return values || codes; }
  [[nodiscard]] const BrickMask* kept() const { return values ? &values->kept : codes->kept(); }
  [[nodiscard]] const BrickMask* hole() const {
    if (values) return values->hole.get();
    return codes ? codes->hole() : nullptr;
  }
};

// Sums bricks, of which there are some, plane by plane: what is made of codes stays in the processor's
// caches.
class BrickSum {
 public:
  void add(const PartBrick& brick) {
    if (bricks_.empty()) kept_ = {};
    bricks_.push_back(brick);
    const BrickMask* kept = brick.kept();
    for (size_t i = 0; i < brick_rows; ++i)
      kept_[i] = static_cast<uint16_t>(kept_[i] | (kept ? (*kept)[i] : 0xffff));
  }
  [[nodiscard]] bool empty() const { return bricks_.empty(); }
  std::shared_ptr<Brick> take(std::array<float, 2>& range) {
    auto out = std::make_shared_for_overwrite<Brick>();
    out->kept = kept_;
    planes_.resize(bricks_.size()), from_.resize(bricks_.size());
    weights_.clear();
    for (const PartBrick& b : bricks_) weights_.push_back(b.weight);
    for (int z = 0; z < brick_edge; ++z) {
      for (size_t k = 0; k < bricks_.size(); ++k) {
        from_[k] = planes_[k].value.data();
        if (bricks_[k].values)
          from_[k] = bricks_[k].values->value.data() + z * brick_rows;
        else
          bricks_[k].codes->read({.plane = z}, planes_[k].value.data(), brick_edge);
      }
      HWY_DYNAMIC_DISPATCH(MergePlanes)
      (from_.data(), weights_.data(), bricks_.size(), out->value.data() + z * brick_rows, range.data());
    }
    bricks_.clear();
    return out;
  }

 private:
  struct Plane {
    alignas(64) std::array<float, brick_rows + brick_edge> value;
  };
  std::vector<PartBrick> bricks_;
  BrickMask kept_{};
  std::vector<Plane> planes_;
  std::vector<const float*> from_;
  std::vector<float> weights_;
};

// Merges one coset's layers; `range` grows to hold every coefficient.
BrickLayer merge(const Lattice3& lattice, int coset, const std::vector<Part>& parts,
                 std::array<float, 2>& range, const Context& context) {
  BrickLayer result(lattice, coset);
  // The layer that weighs most decides what is a hole.
  const auto main = std::max_element(parts.begin(), parts.end(), [](const Part& a, const Part& b) {
    return std::fabs(a.weight) < std::fabs(b.weight);
  });
  const size_t row = result.brick_dims()[0];
  std::vector<std::array<float, 2>> ranges(result.brick_slots() / row);
  std::atomic<uint64_t> done{0};
  context.tasks.parallel_for(ranges.size(), [&](uint64_t r) {
    context.progress.advance(done.fetch_add(1, std::memory_order_relaxed), ranges.size());
    BrickSum sum;
    for (size_t slot = r * row; slot < (r + 1) * row; ++slot) {
      for (const Part& part : parts)
        if (const PartBrick brick(part, slot); brick) sum.add(brick);
      if (sum.empty()) continue;
      const auto out = sum.take(ranges[r]);
      if (const BrickMask* hole = PartBrick(*main, slot).hole())
        out->hole = std::make_unique<BrickMask>(*hole);
      result.set(slot, out);
    }
  });
  for (const auto& [low, high] : ranges) range = {std::min(range[0], low), std::max(range[1], high)};
  return result;
}

} // namespace

std::vector<LayerWeight> instant_weights(const Lattice4& lattice, const Kernel& kernel, double frame) {
  if (lattice.is_static()) return static_weights(lattice);
  const double t = frame * kernel_time_per_frame(lattice);
  return layer_weights(lattice, kernel, t, t, [&](double at) { return kernel.time.value(at - t); });
}

std::vector<LayerWeight> mean_weights(const Lattice4& lattice, const Kernel& kernel, double begin,
                                      double end) {
  if (lattice.is_static()) return static_weights(lattice);
  const double unit = kernel_time_per_frame(lattice);
  const double t0 = begin * unit, t1 = end * unit;
  return layer_weights(lattice, kernel, t0, t1,
                       [&](double at) { return kernel.time.integral(t0 - at, t1 - at) / (t1 - t0); });
}

std::array<double, 2> time_span(const Lattice4& lattice, double begin, double end) {
  const double last = lattice.last_frame(), beyond = lattice.periodic ? last : 0;
  return {std::clamp(begin, -beyond, last + beyond), std::clamp(end, -beyond, last + beyond)};
}

namespace {

// Returns the interval around the frame, clipped to the series.
std::array<double, 2> clipped_interval(const Lattice4& lattice, double frame,
                                       const std::array<double, 2>& interval) {
  if (!lattice.is_static() && time_span(lattice, frame, frame) != std::array{frame, frame})
    fail(Code::out_of_domain, "slice: frame ", frame, " is outside the series, 0 to ", lattice.last_frame());
  if (!(interval[0] <= interval[1]))
    fail(Code::invalid_argument, "slice: the interval ", interval[0], " .. ", interval[1], " is not ordered");
  if (interval[0] == interval[1]) return {frame, frame};
  return time_span(lattice, frame + interval[0], frame + interval[1]);
}

// Making layers is about this share of a slice's work, for reports of progress; merging them is the rest.
constexpr double merge_begin = 0.9;

// Merges the cosets of a lattice; `range` grows to hold every coefficient.
MergedCosets merge_cosets(const Lattice3& lattice, const std::vector<Part>& parts,
                          std::array<float, 2>& range, const Context& context) {
  MergedCosets out;
  for (int c = 0; c < lattice.cosets(); ++c) {
    std::vector<Part> of_coset;
    for (const Part& p : parts)
      if (p.coset == c) of_coset.push_back(p);
    const double share = 1.0 / lattice.cosets();
    Progress merging(context.progress, c * share, (c + 1) * share);
    out[static_cast<size_t>(c)] = merge(lattice, c, of_coset, range, context.with(merging));
  }
  return out;
}

bool has_holes(const Part& part) {
  for (size_t slot = 0; slot < part.of.brick_slots(); ++slot)
    if (part.of.there(slot) && part.of.hole(slot)) return true;
  return false;
}

// The parts of a moment: mirror images of a layer are one part.
std::vector<Part> moment_parts(const Coefficients& coefficients, const std::vector<Part>& parts,
                               const Context& context) {
  std::vector<Part> out;
  for (const Part& part : parts) {
    const int32_t inside = coefficients.source().lattice().mirror_layer(part.layer);
    const auto found = std::find_if(out.begin(), out.end(), [&](const Part& p) { return p.layer == inside; });
    if (found != out.end()) {
      found->weight += part.weight;
      continue;
    }
    out.push_back(part);
    out.back().layer = inside, out.back().range = coefficients.range(inside, part.of, context);
  }
  return out;
}

// Leaves the merging of a slice's cosets for later.
void put_off(Slice& slice, const Coefficients& coefficients, const std::vector<Part>& parts,
             const Context& context) {
  const auto merge_all = [lattice = slice.lattice](const std::vector<Part>& all, const Context& with) {
    std::array<float, 2> range{};
    return merge_cosets(lattice, all, range, with);
  };
  const auto moment = std::make_shared<const MomentPlan>(
      coefficients.number(), moment_parts(coefficients, parts, context), merge_all);
  slice.coset = SliceCosets(moment);
  slice.bounds = coefficient_bounds(slice, moment->range());
}

// Makes a slice at `frame` of weighted layers; `length` multiplies what they add up to.
Slice merged_slice(const Coefficients& coefficients, double frame, std::vector<LayerWeight> weights,
                   double length, const Affine3& index_to_world, const Context& context, bool later) {
  const auto start = std::chrono::steady_clock::now();
  const Lattice4& lattice = coefficients.source().lattice();
  if (length != 1)
    for (LayerWeight& l : weights) l.weight = static_cast<float>(l.weight * length);
  Slice slice;
  slice.lattice = lattice.space;
  slice.kernel = coefficients.kernel();
  slice.base = static_cast<float>(coefficients.base() * length);
  slice.air = static_cast<float>(coefficients.air() * length);
  slice.frame = frame;
  std::vector<int32_t> wanted;
  for (const LayerWeight& l : weights) wanted.push_back(l.layer);
  Progress making(context.progress, 0, merge_begin), merging(context.progress, merge_begin, 1);
  const auto layers = coefficients.compact_layers(wanted, context.with(making));
  std::vector<Part> parts;
  for (size_t i = 0; i < weights.size(); ++i)
    parts.push_back({wanted[i], lattice.coset(wanted[i]), weights[i].weight, {}, layers[i]});
  if (later && !lattice.is_static() && std::none_of(parts.begin(), parts.end(), has_holes)) {
    put_off(slice, coefficients, parts, context);
  } else {
    std::array<float, 2> range{};
    MergedCosets merged = merge_cosets(lattice.space, parts, range, context.with(merging));
    for (int c = 0; c < lattice.space.cosets(); ++c) {
      BrickLayer& coset = slice.coset[c];
      coset = std::move(merged[static_cast<size_t>(c)]);
      for (size_t n = 0; n < coset.brick_slots() && !slice.has_holes; ++n)
        slice.has_holes = coset.brick(n) && coset.brick(n)->hole;
    }
    slice.bounds = coefficient_bounds(slice, range);
  }

  const Vec3 unit = lattice.lattice_unit();
  slice.domain_begin = lattice.first_sample();
  for (size_t a = 0; a < 3; ++a) {
    slice.domain_end[a] = slice.domain_begin[a] + lattice.domain_end(a) / unit[a];
    slice.lattice_to_slice.linear[a] = {};
    slice.lattice_to_slice.linear[a][a] = unit[a];
    slice.lattice_to_slice.offset[a] = -(lattice.before[a] * lattice.space_step[a]);
    slice.basis[a] = {};
    slice.basis[a][a] = 1;
  }
  slice.slice_to_world = index_to_world;
  slice.hyperplane = {0, 0, 0, 1, -frame};
  slice.origin = {0, 0, 0, frame};
  slice.milliseconds =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  return slice;
}

// A slice with the corrections and the mask of the file. Where its layers have to wait, these are tried for
// all the same, so that the host hears of everything at once.
template<class Merge>
Slice mended(const Merge& merged, const Coefficients& coefficients, const std::array<double, 2>& moments,
             ThicknessKind kind, double mask_at) {
  Slice slice;
  Attempts attempts;
  attempts.attempt([&] { slice = merged(); });
  attempts.attempt([&] { correct_time_slice(slice, coefficients, moments[0], moments[1], kind); });
  slice.frame = mask_at;
  attempts.attempt([&] { mask_time_slice(slice, coefficients); });
  attempts.throw_if_waiting();
  return slice;
}

} // namespace

Slice time_slice(const Coefficients& coefficients, double frame, const std::array<double, 2>& interval,
                 const Affine3& index_to_world, const Context& context) {
  return thick_time_slice(coefficients, frame, interval, ThicknessKind::mean, index_to_world, context);
}

void prepare_time_slice(const Coefficients& coefficients, double frame, const std::array<double, 2>& interval,
                        const Context& context) {
  const Lattice4& lattice = coefficients.source().lattice();
  const auto [t0, t1] = clipped_interval(lattice, frame, interval);
  std::vector<int32_t> layers;
  for (const LayerWeight& l : t1 > t0 ? mean_weights(lattice, coefficients.kernel(), t0, t1)
                                      : instant_weights(lattice, coefficients.kernel(), t0))
    layers.push_back(l.layer);
  (void)coefficients.compact_layers(layers, context);
}

Slice thick_time_slice(const Coefficients& coefficients, double frame, const std::array<double, 2>& interval,
                       ThicknessKind kind, const Affine3& index_to_world, const Context& context,
                       bool later) {
  const Lattice4& lattice = coefficients.source().lattice();
  const auto [t0, t1] = clipped_interval(lattice, frame, interval);
  const double from = t0, to = t1;                              // structured bindings are not captured
  if (kind == ThicknessKind::maximum && t1 > t0) later = false; // which looks at the bricks of instants
  const auto instant = [&](double at, const Context& with) {
    const auto merged = [&] {
      return merged_slice(coefficients, frame, instant_weights(lattice, coefficients.kernel(), at), 1,
                          index_to_world, with, later);
    };
    Slice slice = mended(merged, coefficients, {at, at}, kind, at);
    slice.frame = frame;
    return slice;
  };
  if (!(t1 > t0)) return instant(t0, context);
  if (kind == ThicknessKind::maximum) {
    SiteMaxima maxima;
    const double density = 1 / lattice.nominal_scales()[3];
    const std::vector<double> node = gauss_legendre(thickness_nodes(t1 - t0, density)).node;
    const double part = 1 / static_cast<double>(node.size() + 1);
    Attempts attempts;
    for (size_t k = 0; k < node.size(); ++k) {
      const double begin = static_cast<double>(k) * part;
      Progress making(context.progress, begin, begin + part / 2),
          comparing(context.progress, begin + part / 2, begin + part);
      attempts.attempt([&] {
        maxima.add(instant(from + (to - from) * node[k], context.with(making)), context.with(comparing));
      });
    }
    attempts.throw_if_waiting();
    Progress filtering(context.progress, 1 - part, 1);
    return maxima.finish(context.with(filtering));
  }
  const auto merged = [&] {
    return merged_slice(coefficients, frame, mean_weights(lattice, coefficients.kernel(), from, to),
                        kind == ThicknessKind::sum ? to - from : 1, index_to_world, context, later);
  };
  return mended(merged, coefficients, {t0, t1}, kind, frame);
}

} // namespace bccsplat
#endif
