// SPDX-License-Identifier: Apache-2.0
// The sixteen rows of a plane are rounded in the lanes of vectors, each two sites behind the row before it,
// whose errors it needs up to the next site; and planes follow each other without a pause. Cells are laid out
// by these steps, so that the errors that all lanes need from one direction stand side by side. Sums are made
// in the order of round_units_reference, which every target equals to the bit.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "formats/bcc4/encode/round_units.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <memory>

#include "formats/bcc4/encode/round_units.h"

#ifndef BCCSPLAT_ROUND_UNITS_STEPS
#define BCCSPLAT_ROUND_UNITS_STEPS
namespace bccsplat {
namespace {

// Site (x, y, z) comes at step x + behind * y + plane_steps * z in lane y. Between two rows of a lane is a
// step for the cell that stands beyond both.
constexpr int behind = 2, plane_steps = brick_edge + 1;
constexpr int steps = plane_steps * brick_edge + behind * (brick_edge - 1);
// Cells of errors: the lanes stand aligned, with a border on either side, and the steps of neighbours before
// the first and after the last step are there.
constexpr int pitch = brick_edge + 8, first_lane = 8, step_border = plane_steps + behind + 1;
constexpr int error_cells = (steps + 2 * step_border + 1) * pitch;

constexpr std::ptrdiff_t cell_offset(const Int3& site) {
  return (site[0] + behind * site[1] + plane_steps * site[2]) * pitch + site[1];
}
constexpr size_t step_site(int x, int y, int z) {
  return (x + behind * y + plane_steps * z) * brick_edge + y;
}

// What an error is multiplied by, and where it stands, seen from lane 0 of a step.
struct ErrorTap {
  const double* at;
  double weight;
};
struct ErrorTaps {
  std::array<ErrorTap, max_taps> tap;
  size_t count = 0;
};

// What the steps of a layer work on.
struct StepRows {
  const float* values; // by step and lane; 0 where there is nothing to round
  double* errors;
  int32_t* units;
};

} // namespace
} // namespace bccsplat
#endif

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
namespace {

using Lanes = hn::CappedTag<double, brick_edge / 2>;
using Values = hn::Rebind<float, Lanes>;
using Units = hn::Rebind<int32_t, Lanes>;

HWY_INLINE bool AnyGiven(const float* values) {
  const hn::CappedTag<float, brick_edge> d;
  for (size_t y = 0; y < brick_edge; y += hn::Lanes(d))
    if (!hn::AllTrue(d, hn::Eq(hn::LoadU(d, values + y), hn::Zero(d)))) return true;
  return false;
}

// Rounds what is wanted of some lanes, where there is a value.
HWY_INLINE void RoundLanes(hn::Vec<Lanes> handed_on, const float* HWY_RESTRICT values, double unit,
                           double most, double* HWY_RESTRICT errors, int32_t* HWY_RESTRICT units) {
  const Lanes d;
  const auto value = hn::PromoteTo(d, hn::LoadU(Values(), values));
  const auto wanted = hn::Add(hn::Mul(handed_on, hn::Set(d, 1.0 / (1 << fraction_bits))), value);
  const auto nearest = hn::Floor(hn::Add(hn::Div(wanted, hn::Set(d, unit)), hn::Set(d, 0.5)));
  const auto rounded = hn::Min(hn::Max(nearest, hn::Set(d, -most)), hn::Set(d, most));
  const auto given = hn::Ne(value, hn::Zero(d));
  const auto error = hn::Sub(hn::Mul(rounded, hn::Set(d, unit)), wanted);
  hn::StoreU(hn::IfThenElseZero(given, error), d, errors);
  hn::StoreU(hn::DemoteTo(Units(), hn::IfThenElseZero(given, rounded)), Units(), units);
}

void RoundSteps(const StepRows& rows, const ErrorTaps& taps, double unit, double most) {
  const Lanes d;
  const size_t lanes = hn::Lanes(d);
  for (std::ptrdiff_t step = 0; step < steps; ++step) {
    const float* values = rows.values + step * brick_edge;
    double* errors = rows.errors + step * pitch;
    int32_t* units = rows.units + step * brick_edge;
    if (!AnyGiven(values)) {
      std::fill_n(errors, brick_edge, 0.0);
      std::fill_n(units, brick_edge, 0);
      continue;
    }
    // Two vectors at a time, as each sum waits for the one before it.
    for (size_t y = 0; y < brick_edge; y += 2 * lanes) {
      auto low = hn::Zero(d), high = hn::Zero(d);
      const size_t at = step * pitch + y;
      for (size_t i = 0; i < taps.count; ++i) {
        const auto weight = hn::Set(d, taps.tap[i].weight);
        low = hn::Add(low, hn::Mul(weight, hn::LoadU(d, taps.tap[i].at + at)));
        high = hn::Add(high, hn::Mul(weight, hn::LoadU(d, taps.tap[i].at + at + lanes)));
      }
      RoundLanes(low, values + y, unit, most, errors + y, units + y);
      RoundLanes(high, values + y + lanes, unit, most, errors + y + lanes, units + y + lanes);
    }
  }
}

// Rounds without errors, so that sites do not wait for each other.
void RoundValues(const float* HWY_RESTRICT values, double unit, double most, int32_t* HWY_RESTRICT units) {
  const Lanes d;
  for (size_t i = 0; i < brick_sites; i += hn::Lanes(d)) {
    const auto value = hn::PromoteTo(d, hn::LoadU(Values(), values + i));
    const auto nearest = hn::Floor(hn::Add(hn::Div(value, hn::Set(d, unit)), hn::Set(d, 0.5)));
    const auto rounded = hn::Min(hn::Max(nearest, hn::Set(d, -most)), hn::Set(d, most));
    hn::StoreU(hn::DemoteTo(Units(), rounded), Units(), units + i);
  }
}

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {

HWY_EXPORT(RoundSteps);
HWY_EXPORT(RoundValues);

namespace {

// Three layers of errors, values and units by steps. What stands beyond the bricks stays 0.
class StepRoom {
 public:
  StepRoom()
      : errors_(std::make_unique<double[]>(size_t{3} * error_cells)),
        values_(std::make_unique<float[]>(site_count)), units_(std::make_unique<int32_t[]>(site_count)) {}

  // Lane 0 of step 0.
  [[nodiscard]] double* errors(int m) const {
    return errors_.get() + (m % 3) * error_cells + step_border * pitch + first_lane;
  }
  [[nodiscard]] StepRows take(int m, const Brick& brick, const Int3& box) const {
    const float* from = brick.value.data();
    for (int z = 0; z < brick_edge; ++z)
      for (int y = 0; y < brick_edge; ++y, from += brick_edge) {
        const bool inside = z < box[2] && y < box[1];
        for (int x = 0; x < brick_edge; ++x) values_[step_site(x, y, z)] = inside && x < box[0] ? from[x] : 0;
      }
    return {values_.get(), errors(m), units_.get()};
  }
  void give(LayerUnits& to) const {
    int32_t* next = to.data();
    for (int z = 0; z < brick_edge; ++z)
      for (int y = 0; y < brick_edge; ++y)
        for (int x = 0; x < brick_edge; ++x) *next++ = units_[step_site(x, y, z)];
  }

 private:
  static constexpr size_t site_count = size_t{steps} * brick_edge;
  std::unique_ptr<double[]> errors_;
  std::unique_ptr<float[]> values_;
  std::unique_ptr<int32_t[]> units_;
};

// Returns the taps in the order of gather_taps. Layers without a brick have no errors.
ErrorTaps taps_of(const StepRoom& room, const ChunkShape& shape, std::span<const Brick* const> bricks, int m,
                  const Weights& weights) {
  ErrorTaps taps;
  const auto* weight = weights.begin();
  const auto add = [&](int layer, const Int3& site) {
    const double w = *weight++;
    if (w != 0 && bricks[layer]) taps.tap[taps.count++] = {room.errors(layer) + cell_offset(site), w};
  };
  for (const int o : own_offset) add(m, sites_of_offset(o));
  const int low = shape.coset(m) == 1 ? 0 : -1;
  if (shape.has_cross(m))
    for (int i = 0; i < cross_taps; ++i) add(m - 1, {low + (i & 1), low + (i >> 1 & 1), low + (i >> 2)});
  if (shape.has_previous(m))
    for (const int o : previous_offset) add(m - shape.period, sites_of_offset(o));
  return taps;
}

} // namespace

void round_units(const ChunkShape& shape, std::span<const Brick* const> bricks, const UnitRounding& how,
                 std::span<LayerUnits> units) {
  if (how.weights.empty()) {
    for (size_t m = 0; m < bricks.size(); ++m)
      if (bricks[m])
        HWY_DYNAMIC_DISPATCH(RoundValues)(bricks[m]->value.data(), how.unit, how.most, units[m].data());
    return;
  }
  const StepRoom room;
  for (int m = 0; m < shape.layers; ++m) {
    const size_t i = m;
    if (!bricks[i]) continue;
    HWY_DYNAMIC_DISPATCH(RoundSteps)
    (room.take(m, *bricks[i], shape.box[i]), taps_of(room, shape, bricks, m, how.weights[i]), how.unit,
     how.most);
    room.give(units[i]);
  }
}

} // namespace bccsplat
#endif
