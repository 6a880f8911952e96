// SPDX-License-Identifier: Apache-2.0
// Frames are left out in turn, and where that says so the flow between the two around a moment is found. What
// is known of frames and intervals stays until it is let go.
#include "motion/finder.h"

#include <algorithm>
#include <array>
#include <set>

#include "motion/keep_nearest.h"
#include "motion/shares.h"

namespace bccsplat::motion {
namespace {

constexpr double most_uneven = 1.5; // an interval, beside the other one of a trial

// Every second frame, frame i not among them.
std::vector<size_t> frames_between(size_t i, size_t count) {
  std::vector<size_t> numbers;
  for (size_t j = (i + 1) % 2; j < count; j += 2) numbers.push_back(j);
  return numbers;
}

} // namespace

bool Finder::can_be_tried(size_t i) const {
  if (i == 0 || i + 1 >= times_.size()) return false;
  const double before = times_[i] - times_[i - 1], behind = times_[i + 1] - times_[i];
  return std::max(before, behind) <= most_uneven * std::min(before, behind);
}

std::vector<Share> Finder::trial_shares(size_t i) const {
  const std::vector<size_t> numbers = frames_between(i, times_.size());
  std::vector<double> times;
  for (const size_t n : numbers) times.push_back(times_[n]);
  std::vector<Share> shares = cubic_shares(times, times_[i]);
  for (Share& s : shares) s.frame = numbers[s.frame];
  return shares;
}

std::vector<size_t> Finder::lacks(size_t i) const {
  if (intervals_.contains(i)) return {};
  std::set<size_t> frames{i, i + 1};
  for (const size_t end : {i, i + 1}) {
    if (trials_.contains(end) || !can_be_tried(end)) continue;
    frames.insert({end - 1, end, end + 1});
    for (const Share& s : trial_shares(end)) frames.insert(s.frame);
  }
  std::vector<size_t> lacking;
  for (const size_t f : frames)
    if (!frames_.contains(f)) lacking.push_back(f);
  return lacking;
}

const Trial& Finder::trial(size_t i) {
  if (const auto known = trials_.find(i); known != trials_.end()) return known->second;
  const std::vector<Share> shares = trial_shares(i);
  std::vector<const Spline*> frames(times_.size());
  for (const Share& s : shares) frames[s.frame] = &spline(s.frame);
  const std::array around{times_[i - 1], times_[i + 1]};
  const Flow flow = find_flow(frames_.at(i - 1)->sketch, frames_.at(i + 1)->sketch, options_);
  Trial tried = try_frame(flow, frames, shares, before_middle(around, times_[i]), frames_.at(i)->box);
  return trials_.emplace(i, std::move(tried)).first->second;
}

Interval Finder::find(size_t i) {
  const Sketch &first = frames_.at(i)->sketch, &second = frames_.at(i + 1)->sketch;
  std::vector<const Trial*> trials;
  for (const size_t end : {i, i + 1})
    if (can_be_tried(end)) trials.push_back(&trial(end));
  Interval found;
  if (trials.empty()) {
    found.flow = find_flow(first, second, options_);
    found.mask = soft_mask(try_interval(found.flow, spline(i), spline(i + 1)));
    return found;
  }
  found.mask = gate(trials);
  if (found.follows()) {
    found.flow = find_flow(first, second, options_);
  } else {
    found.flow.nodes = nodes_over(frames_.at(i)->box.dims, options_.spacing);
    found.flow.velocity.resize(found.mask.size());
  }
  return found;
}

std::shared_ptr<const Interval> Finder::interval(size_t i) {
  if (const auto known = intervals_.find(i); known != intervals_.end()) return known->second;
  return intervals_.emplace(i, std::make_shared<const Interval>(find(i))).first->second;
}

uint64_t Finder::frame_bytes(const Int3& dims) {
  const auto samples = [&](int32_t more) {
    uint64_t n = 1;
    for (const int32_t d : dims) n *= static_cast<uint64_t>(d + more);
    return n;
  };
  // Itself, its spline, and all coarser copies with a spline of the finest: no more than as many once more.
  return sizeof(float) * (samples(0) + 2 * samples(3));
}

uint64_t Finder::bytes() const {
  uint64_t bytes = 0;
  for (const auto& [i, frame] : frames_) bytes += frame_bytes(frame->box.dims);
  for (const auto& [i, tried] : trials_) bytes += tried.still.size() * 2 * sizeof(float);
  for (const auto& [i, found] : intervals_) bytes += found->bytes();
  return bytes;
}

void Finder::keep(size_t i, size_t frames, size_t intervals) {
  keep_nearest(frames_, i, frames);
  keep_nearest(trials_, i, intervals + 1);
  keep_nearest(intervals_, i, intervals);
}

} // namespace bccsplat::motion
