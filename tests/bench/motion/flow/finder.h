// SPDX-License-Identifier: Apache-2.0
// Moments of a series that follow the motion: what is found of its frames and intervals, each once.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <vector>

#include "tests/bench/motion/flow/box.h"
#include "tests/bench/motion/flow/flow.h"
#include "tests/bench/motion/flow/gate.h"
#include "tests/bench/motion/flow/spline.h"

namespace bccsplat::motion {

// What is known between a frame and the next.
struct Interval {
  Flow flow;
  std::vector<float> mask; // shares of the motion at the flow's nodes
};

struct SumOptions {
  bool cubic = true; // four frames, else two
  bool gated = true; // by the mask, else everywhere
};

class Finder {
 public:
  // times: of the frames, rising, two at least. read: a frame of theirs.
  Finder(std::vector<double> times, std::function<Box(size_t)> read, FlowOptions options = {})
      : times_(std::move(times)), read_(std::move(read)), options_(options), frames_(times_.size()) {}

  [[nodiscard]] const std::vector<double>& times() const { return times_; }
  // From frame i to frame i + 1.
  [[nodiscard]] const Interval& interval(size_t i);
  // still: the moment without motion, on the samples of the frames.
  [[nodiscard]] Box moment(double time, const Box& still, const SumOptions& options = {});

 private:
  struct Frame {
    Box box;
    Sketch sketch;
    Spline spline;
    explicit Frame(Box given) : box(std::move(given)), sketch(box), spline(box) {}
  };
  [[nodiscard]] const Frame& frame(size_t i);
  // Null where a frame has no neighbours that are about as far on either side.
  [[nodiscard]] const Trial* trial(size_t i);
  [[nodiscard]] std::vector<float> mask_of(size_t i, const Flow& flow);
  // Those that shares name, the others null.
  [[nodiscard]] std::vector<const Spline*> splines(const std::vector<Share>& shares);

  std::vector<double> times_;
  std::function<Box(size_t)> read_;
  FlowOptions options_;
  std::vector<std::unique_ptr<Frame>> frames_;
  std::map<size_t, Trial> trials_;
  std::map<size_t, Interval> intervals_;
};

} // namespace bccsplat::motion
