// SPDX-License-Identifier: Apache-2.0
// Optional low-pass before resampling: removes what D4* (static: BCC) cannot hold.
//
// The separable resampling filters keep a whole cube of frequencies; the lattice holds the 24-cell
// |f_i| + |f_j| <= sqrt2 for every pair of axes (in space alone the rhombic dodecahedron), f in units of the
// Nyquist frequency of a grid of the lattice distance, and what lies outside folds back. The cell is the
// intersection of six octagons, one for each pair of axes, so the filter is a product of six 2D filters: a
// windowed ideal response each (Kaiser along both diagonals). The three that involve time run as a chain of
// sliding windows. Ends are mirrored as those of the resampling are; of a periodic series the first frames
// come once more behind the last one.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <vector>

#include "base/context.h"
#include "fit/frame/frame.h"
#include "fit/resample/holes.h"
#include "lattice/lattice.h"

namespace bccsplat {

// Weights of a pair of axes (i, j): out = v + sum weight * (v(+a,+b) + v(+a,-b) + v(-a,+b) + v(-a,-b) - 4 v),
// which leaves a constant exactly as it is.
struct LowpassPair {
  struct Tap {
    int32_t a = 0, b = 0; // samples along i and j, >= 0
    float weight = 0;
  };
  std::array<size_t, 2> axis{};
  std::array<int32_t, 2> reach{}; // largest a and b
  std::vector<Tap> tap;
};

// unit: the lattice distance along both axes in samples.
[[nodiscard]] LowpassPair lowpass_pair(std::array<size_t, 2> axis, std::array<double, 2> unit);

// Frames that a filtered frame depends on, in either direction of time.
[[nodiscard]] int32_t lowpass_time_reach(const Lattice4& lattice);

// The part of a frame that the filter does not touch and that is needed again when the frame leaves.
struct LowpassOrigin {
  std::vector<uint8_t> air; // a bit for each sample, x fastest
  HoleMap holes;
  Reservation memory;
};

// A dense frame relative to air: rows of `pitch` floats whose first sample is at `margin`.
struct LowpassFrame {
  std::vector<float> value;
  std::vector<uint8_t> empty; // by row z * ny + y: nothing but air
  std::shared_ptr<const LowpassOrigin> origin;
  Reservation memory;
};

// One channel. Memory: frames within reach as dense floats (lowpass_time_reach, twice, and some).
class Lowpass {
 public:
  // Called in the order of the frames; of a periodic series from frame lowpass_time_reach on, and for those
  // before it last.
  using Sink = std::function<void(const Frame& frame, const HoleMap& holes)>;

  // ringing: what the filter leaves where the source is air is air again up to this fraction of the largest
  // departure nearby.
  Lowpass(const Lattice4& lattice, float ringing);

  // The next frame, relative to its air; null: it is missing altogether and holds what the one before holds,
  // the first ones what follows them.
  void add(const Frame* frame, HoleMap holes, const Sink& sink, const Context& context);
  // No more frames: hands out the rest.
  void finish(const Sink& sink, const Context& context);

 private:
  using FramePtr = std::shared_ptr<const LowpassFrame>;
  struct Stage { // of a pair with time
    LowpassPair pair;
    std::deque<FramePtr> window;
    int64_t first = 0, next = 0; // frame of window.front(), and the next to be made; counted from the first
  };
  using At = std::function<const LowpassFrame&(int64_t offset)>; // frames by their distance in time

  [[nodiscard]] std::shared_ptr<LowpassFrame> make_frame(const Context& context) const;
  [[nodiscard]] FramePtr read(const Frame& frame, HoleMap holes, const Context& context) const;
  [[nodiscard]] FramePtr apply(const LowpassPair& pair, const LowpassFrame& centre, const At& at,
                               const Context& context) const;
  [[nodiscard]] FramePtr again(const LowpassFrame& frame, HoleMap holes, const Context& context) const;
  void push_missing(const Sink& sink, const Context& context);
  void close_row(LowpassFrame& frame, size_t row) const;
  void push_first(const FramePtr& frame, const Sink& sink, const Context& context);
  void push(size_t stage, FramePtr frame, bool last, const Sink& sink, const Context& context);
  void hand_out(const LowpassFrame& filtered, const Sink& sink, const Context& context) const;

  std::array<int64_t, 3> n_{};
  float ringing_ = 0;
  int64_t margin_ = 0, pitch_ = 0;
  std::array<std::vector<int64_t>, 3> mirror_; // index + reach -> sample
  std::array<int32_t, 3> reach_{};             // of all pairs
  std::vector<LowpassPair> space_;
  std::vector<Stage> time_;
  FramePtr previous_;            // the last one that was given, filtered in space
  std::vector<HoleMap> missing_; // frames at the start
  bool periodic_ = false;        // in time
  AxisFlags turning_{};          // the same along axes of space
  size_t turn_ = 0; // frames of a periodic series that come once more at its end, where it is as long
  std::vector<FramePtr> head_; // these
};

} // namespace bccsplat
