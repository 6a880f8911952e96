// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/motion/flow/finder.h"

#include <algorithm>

#include "tests/bench/motion/flow/shares.h"
#include "tests/bench/motion/flow/warped.h"

namespace bccsplat::motion {
namespace {

constexpr double most_uneven = 1.5; // an interval, beside the other one of a trial

float before_middle(std::span<const double> times, double time) {
  const size_t i = interval_of(times, time);
  return static_cast<float>(.5 - (time - times[i]) / (times[i + 1] - times[i]));
}

} // namespace

const Finder::Frame& Finder::frame(size_t i) {
  if (!frames_[i]) frames_[i] = std::make_unique<Frame>(read_(i));
  return *frames_[i];
}

std::vector<const Spline*> Finder::splines(const std::vector<Share>& shares) {
  std::vector<const Spline*> named(times_.size());
  for (const Share& s : shares) named[s.frame] = &frame(s.frame).spline;
  return named;
}

const Trial* Finder::trial(size_t i) {
  if (i == 0 || i + 1 >= times_.size()) return nullptr;
  const double before = times_[i] - times_[i - 1], behind = times_[i + 1] - times_[i];
  if (std::max(before, behind) > most_uneven * std::min(before, behind)) return nullptr;
  if (const auto known = trials_.find(i); known != trials_.end()) return &known->second;
  // As a moment between frames twice as far from each other, this one not among them.
  std::vector<double> times;
  std::vector<size_t> numbers;
  for (size_t j = (i + 1) % 2; j < times_.size(); j += 2) times.push_back(times_[j]), numbers.push_back(j);
  std::vector<Share> shares = cubic_shares(times, times_[i]);
  for (Share& s : shares) s.frame = numbers[s.frame];
  const Flow flow = find_flow(frame(i - 1).sketch, frame(i + 1).sketch, options_);
  const auto named = splines(shares);
  return &trials_.emplace(i, try_frame(flow, named, shares, before_middle(times, times_[i]), frame(i).box))
              .first->second;
}

std::vector<float> Finder::mask_of(size_t i, const Flow& flow) {
  std::vector<const Trial*> trials;
  for (const size_t end : {i, i + 1})
    if (const Trial* const t = trial(end)) trials.push_back(t);
  if (trials.empty()) return soft_mask(try_interval(flow, frame(i).spline, frame(i + 1).spline));
  return gate(trials);
}

const Interval& Finder::interval(size_t i) {
  if (const auto known = intervals_.find(i); known != intervals_.end()) return known->second;
  Interval found{find_flow(frame(i).sketch, frame(i + 1).sketch, options_), {}};
  found.mask = mask_of(i, found.flow);
  return intervals_.emplace(i, std::move(found)).first->second;
}

Box Finder::moment(double time, const Box& still, const SumOptions& options) {
  const Interval& here = interval(interval_of(times_, time));
  const std::vector<Share> shares = options.cubic ? cubic_shares(times_, time) : linear_shares(times_, time);
  const auto named = splines(shares);
  return sum_along(Ways(here.flow, named, shares, before_middle(times_, time)), here.flow,
                   options.gated ? std::span<const float>(here.mask) : std::span<const float>(), still);
}

} // namespace bccsplat::motion
