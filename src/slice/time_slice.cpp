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

#include "base/page_pool.h"
#include "points/brick.h"
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
    auto out = make_pooled_for_overwrite<Brick>();
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

namespace {

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
std::vector<Part> moment_parts(const Coefficients& coefficients, bool still, const std::vector<Part>& parts,
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
    out.back().layer = inside, out.back().range = coefficients.range(inside, still, part.of, context);
  }
  return out;
}

// Leaves the merging of a slice's cosets for later.
void put_off(Slice& slice, const CutPlan& plan, const std::vector<Part>& parts, const Context& context) {
  const auto merge_all = [lattice = slice.lattice](const std::vector<Part>& all, const Context& with) {
    std::array<float, 2> range{};
    return merge_cosets(lattice, all, range, with);
  };
  const auto moment = std::make_shared<const MomentPlan>(
      plan.coefficients->number(plan.still), moment_parts(*plan.coefficients, plan.still, parts, context),
      merge_all);
  slice.coset = SliceCosets(moment);
  slice.bounds = coefficient_bounds(slice, moment->range());
}

// The least and the largest coefficient, and 0.
std::array<float, 2> range_of(const BrickLayer& layer, const Context& context) {
  constexpr size_t lanes = 16; // kept apart, so that compilers may use vectors
  std::vector<std::array<float, 2>> ranges(layer.rows());
  context.tasks.parallel_for(ranges.size(), [&](uint64_t row) {
    std::array<float, lanes> low{}, high{};
    for (size_t slot = row * layer.row_slots(); slot < (row + 1) * layer.row_slots(); ++slot)
      if (const Brick* brick = layer.brick(slot))
        for (size_t i = 0; i < brick_sites; i += lanes)
          for (size_t k = 0; k < lanes; ++k) {
            low[k] = std::min(low[k], brick->value[i + k]);
            high[k] = std::max(high[k], brick->value[i + k]);
          }
    ranges[row] = {*std::min_element(low.begin(), low.end()), *std::max_element(high.begin(), high.end())};
  });
  std::array<float, 2> range{};
  for (const auto& [low, high] : ranges) range = {std::min(range[0], low), std::max(range[1], high)};
  return range;
}

bool has_holes(const BrickLayer& layer) {
  for (size_t slot = 0; slot < layer.brick_slots(); ++slot)
    if (layer.brick(slot) && layer.brick(slot)->hole) return true;
  return false;
}

// Makes a slice's coset of its layers, as one sum or one by one.
void make_cosets(Slice& slice, const CutPlan& plan, const std::vector<LayerWeight>& weights,
                 const Context& context) {
  const Coefficients& coefficients = *plan.coefficients;
  const Lattice4& lattice = coefficients.source().lattice();
  // A sum over time is that many times a mean, which what is left out as too small goes by.
  if (plan.options.once &&
      !(plan.options.thickness.kind == ThicknessKind::sum && plan.frames[1] > plan.frames[0])) {
    std::vector<LayerSum::Term> terms;
    for (const auto& [layer, weight] : weights) terms.push_back({layer, weight});
    if (auto sum = coefficients.sum_at_once(terms, plan.still, context)) {
      slice.bounds = coefficient_bounds(slice, range_of(*sum, context));
      slice.has_holes = has_holes(*sum);
      slice.coset[0] = std::move(*sum);
      return;
    }
  }
  Progress making(context.progress, 0, merge_begin), merging(context.progress, merge_begin, 1);
  const auto layers = layers_of(plan, context.with(making));
  std::vector<Part> parts;
  for (size_t i = 0; i < weights.size(); ++i)
    parts.push_back({weights[i].layer, lattice.coset(weights[i].layer), weights[i].weight, {}, layers[i]});
  const bool holes = std::any_of(parts.begin(), parts.end(), [](const Part& p) { return has_holes(p); });
  if (plan.options.merge_later && !lattice.is_static() && !holes) return put_off(slice, plan, parts, context);
  std::array<float, 2> range{};
  MergedCosets merged = merge_cosets(lattice.space, parts, range, context.with(merging));
  for (int c = 0; c < lattice.space.cosets(); ++c) {
    BrickLayer& coset = slice.coset[c];
    coset = std::move(merged[static_cast<size_t>(c)]);
    slice.has_holes = slice.has_holes || has_holes(coset);
  }
  slice.bounds = coefficient_bounds(slice, range);
}

} // namespace

Slice merged_moment(const CutPlan& plan, const Affine3& index_to_world, const Context& context) {
  const auto start = std::chrono::steady_clock::now();
  const Coefficients& coefficients = *plan.coefficients;
  const Lattice4& lattice = coefficients.source().lattice();
  const double frame = plan.position, span = plan.frames[1] - plan.frames[0],
               length = span > 0 && plan.options.thickness.kind == ThicknessKind::sum ? span : 1;
  std::vector<LayerWeight> weights = plan.layers;
  if (length != 1)
    for (LayerWeight& l : weights) l.weight = static_cast<float>(l.weight * length);
  Slice slice;
  slice.lattice = lattice.space;
  slice.kernel = coefficients.kernel();
  slice.base = static_cast<float>(coefficients.base() * length);
  slice.air = static_cast<float>(coefficients.air() * length);
  slice.frame = frame;
  make_cosets(slice, plan, weights, context);

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

} // namespace bccsplat
#endif
