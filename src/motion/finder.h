// SPDX-License-Identifier: Apache-2.0
// What is found of the frames and intervals of a series, each once.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "motion/box.h"
#include "motion/flow.h"
#include "motion/gate.h"
#include "motion/spline.h"

namespace bccsplat::motion {

// What is known between a frame and the next.
struct Interval {
  Flow flow;
  std::vector<float> mask; // shares of the motion at the flow's nodes

  [[nodiscard]] bool follows() const {
    return std::any_of(mask.begin(), mask.end(), [](float m) { return m > 0; });
  }
  [[nodiscard]] uint64_t bytes() const { return flow.velocity.size() * (sizeof(Float3) + sizeof(float)); }
};

class Finder {
 public:
  // times: of the frames, rising, two at least.
  explicit Finder(std::vector<double> times, FlowOptions options = {})
      : times_(std::move(times)), options_(options) {}

  [[nodiscard]] const std::vector<double>& times() const { return times_; }
  // The frames that interval(i) looks at and that have to be given before: none where it is known.
  [[nodiscard]] std::vector<size_t> lacks(size_t i) const;
  void give(size_t frame, Box box) { frames_[frame] = std::make_unique<Frame>(std::move(box)); }
  // From frame i to frame i + 1.
  [[nodiscard]] std::shared_ptr<const Interval> interval(size_t i);
  // The spline of a frame that was given.
  [[nodiscard]] const Spline& spline(size_t frame) const { return frames_.at(frame)->spline; }
  [[nodiscard]] size_t frames_held() const { return frames_.size(); }
  // Memory of all that it holds.
  [[nodiscard]] uint64_t bytes() const;
  // The same of a frame of so many samples.
  [[nodiscard]] static uint64_t frame_bytes(const Int3& dims);
  // Lets go of what is further from interval i, but for so many frames and intervals.
  void keep(size_t i, size_t frames, size_t intervals);

 private:
  struct Frame {
    Box box;
    Sketch sketch;
    Spline spline;
    explicit Frame(Box given) : box(std::move(given)), sketch(box), spline(box) {}
  };
  // Whether a frame has neighbours that are about as far on either side, between which it can be left out.
  [[nodiscard]] bool can_be_tried(size_t i) const;
  // What frame i is made of when it is left out: of frames twice as far from each other.
  [[nodiscard]] std::vector<Share> trial_shares(size_t i) const;
  [[nodiscard]] const Trial& trial(size_t i);
  // The flow is found where some node may follow it.
  [[nodiscard]] Interval find(size_t i);

  std::vector<double> times_;
  FlowOptions options_;
  std::map<size_t, std::unique_ptr<Frame>> frames_;
  std::map<size_t, Trial> trials_;
  std::map<size_t, std::shared_ptr<const Interval>> intervals_;
};

} // namespace bccsplat::motion
