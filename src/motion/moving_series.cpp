// SPDX-License-Identifier: Apache-2.0
// Frames are read as slices: dense samples of them are for finding the flow, and these themselves, four at a
// time, for moments along it.
#include "motion/moving_series.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "field/sample_grid.h"
#include "motion/keep_nearest.h"
#include "motion/moved_samples.h"
#include "motion/shares.h"
#include "slice/cut_plan.h"
#include "slice/time_slice.h"

namespace bccsplat::motion {
namespace {

constexpr double at_frame = 1e-9; // frames
// Frames held for the next interval while they take no more than this part of the coefficients' cache.
constexpr uint64_t held_part = 4;
constexpr uint64_t most_held = 8;
constexpr size_t most_intervals = 64;
constexpr size_t slices_held = 4; // those of one moment

std::vector<double> frame_times(const Lattice4& lattice, const TimeAxis& axis) {
  std::vector<double> times;
  const auto frames = static_cast<size_t>(lattice.dims[3]);
  for (size_t i = 0; i < frames; ++i) times.push_back(axis.time_of(static_cast<double>(i)));
  if (lattice.periodic && frames > 1) times.push_back(2 * times.back() - times[frames - 2]);
  return times;
}

// Memory that is held if there is any left.
std::optional<Reservation> reserved(MemoryBudget& memory, uint64_t bytes) {
  if (!memory.try_reserve(bytes)) return std::nullopt;
  return Reservation::adopt(memory, bytes);
}

} // namespace

MovingSeries::MovingSeries(const Coefficients& coefficients, const TimeAxis& times)
    : coefficients_(coefficients), times_(frame_times(coefficients.source().lattice(), times)) {
  const Lattice4& lattice = coefficients.source().lattice();
  const Vec3 unit = lattice.lattice_unit();
  for (size_t a = 0; a < 3; ++a) {
    step_[a] = std::max(1, static_cast<int32_t>(std::lround(unit[a])));
    dims_[a] = static_cast<int32_t>(lattice.domain_end(a)) / step_[a] + 1;
  }
}

std::optional<MovingSeries::Between> MovingSeries::between(double frame) const {
  const auto last = static_cast<double>(times_.size() - 1);
  if (coefficients_.source().lattice().is_static() || times_.size() < 2) return std::nullopt;
  if (std::fabs(frame - std::round(frame)) < at_frame || !(frame > 0 && frame < last)) return std::nullopt;
  const auto i = static_cast<size_t>(frame);
  return Between{i, times_[i] + (frame - std::floor(frame)) * (times_[i + 1] - times_[i])};
}

std::vector<size_t> MovingSeries::frames_of(double frame) const {
  const auto at = between(frame);
  if (!at) return {};
  std::vector<size_t> frames;
  for (const Share& s : cubic_shares(times_, at->time)) frames.push_back(s.frame);
  const std::lock_guard lock(mutex_);
  if (!intervals_.contains(at->interval)) {
    const std::vector<size_t> lacking =
        work_ ? work_->finder.lacks(at->interval) : Finder(times_).lacks(at->interval);
    frames.insert(frames.end(), lacking.begin(), lacking.end());
  }
  std::sort(frames.begin(), frames.end());
  frames.erase(std::unique(frames.begin(), frames.end()), frames.end());
  return frames;
}

std::shared_ptr<const Slice> MovingSeries::frame(size_t i, const Context& context) const {
  {
    const std::lock_guard lock(mutex_);
    if (const auto held = frames_.find(i); held != frames_.end()) return held->second.what;
  }
  const CutPlan plan = plan_moment(coefficients_, static_cast<double>(i), {0, 0}, {});
  auto slice = std::make_shared<const Slice>(merged_moment(plan, {}, context));
  Reservation memory(context.memory, slice->bytes(), "frames that a moment follows");
  const std::lock_guard lock(mutex_);
  frames_[i] = {slice, std::move(memory)};
  keep_nearest(frames_, i, slices_held);
  return slice;
}

Box MovingSeries::samples(size_t i, const Context& context) const {
  const auto slice = frame(i, context);
  Box box{dims_, {}};
  box.values.resize(static_cast<size_t>(dims_[0]) * dims_[1] * dims_[2]);
  Grid grid;
  grid.dims = dims_;
  for (size_t a = 0; a < 3; ++a) grid.step[a] = step_[a];
  sample_grid(*slice, grid, box.values.data(), context);
  for (float& v : box.values) // what is missing shows no motion
    if (!std::isfinite(v)) v = slice->air;
  return box;
}

std::shared_ptr<const Interval> MovingSeries::find(Work& work, size_t i, const Context& context) const {
  Finder& finder = work.finder;
  const std::vector<size_t> lacking = finder.lacks(i);
  const uint64_t each = Finder::frame_bytes(dims_);
  const Reservation reading(context.memory, each * lacking.size(), "frames that motion is found on");
  for (size_t n = 0; n < lacking.size(); ++n) {
    context.progress.advance(n, lacking.size());
    finder.give(lacking[n], samples(lacking[n], context));
  }
  auto found = finder.interval(i);
  const uint64_t held = coefficients_.cache_bytes() / held_part / std::max<uint64_t>(each, 1);
  finder.keep(i, static_cast<size_t>(std::min(held, most_held)), 1);
  work.memory = Reservation();
  auto memory = reserved(context.memory, finder.bytes());
  if (memory)
    work.memory = std::move(*memory);
  else
    finder = Finder(times_);
  return found;
}

std::shared_ptr<const Interval> MovingSeries::interval(size_t i, const Context& context) const {
  std::unique_ptr<Work> work;
  {
    const std::lock_guard lock(mutex_);
    if (const auto known = intervals_.find(i); known != intervals_.end()) return known->second.what;
    work = std::move(work_);
  }
  if (!work) work = std::make_unique<Work>(Work{Finder(times_), {}});
  auto found = find(*work, i, context);
  auto memory = reserved(context.memory, found->bytes());
  const std::lock_guard lock(mutex_);
  if (memory) intervals_[i] = {found, std::move(*memory)};
  keep_nearest(intervals_, i, most_intervals);
  if (!work_) work_ = std::move(work);
  return found;
}

void MovingSeries::prepare(double frame, const Context& context) const {
  if (const auto at = between(frame)) (void)interval(at->interval, context);
}

void MovingSeries::follow(Slice& moment, const Context& context) const {
  const auto at = between(moment.frame);
  if (!at) return;
  const auto found = interval(at->interval, context);
  if (!found->follows()) return;
  std::vector<MovedFrame> frames;
  for (const Share& s : cubic_shares(times_, at->time))
    frames.push_back({frame(s.frame, context), s.weight, s.ahead});
  follow_ways(moment, {*found, std::move(frames), before_middle(times_, at->time), step_}, context);
}

} // namespace bccsplat::motion
