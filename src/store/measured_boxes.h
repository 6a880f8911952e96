// SPDX-License-Identifier: Apache-2.0
// Boxes of a frame that are compared with what the file gives, where a part of the frame will do, and how
// what they are off by becomes that of the frame.
//
// Coefficients are made by bricks, so boxes are cut from cells of whole bricks, and end where a kernel would
// reach beyond their cell. The cells are those of two divisions of the frame, one brick apart, as no box of
// one division has what lies between its cells. They are picked in even steps along the sum of what they
// have: a third of it is how much the frame bends there and a third how much it differs from what the frames
// before it let expect, which the errors of a lattice rise with, and a third how much of the frame is not
// air, which those of rounding rise with. What a box stands for is calibrated so that the boxes together have
// the sums of the frame.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fit/frame/frame.h"
#include "lattice/lattice.h"
#include "points/sample_source.h"
#include "store/earlier_frames.h"
#include "store/sample_errors.h"

namespace bccsplat {

inline constexpr int kernel_sites = 4; // a kernel takes at most so many in a row

struct MeasuredBox {
  Region samples;    // of the source
  BrickBox bricks{}; // what the field in there depends on; all of them for a whole frame
  double weight = 1; // mean squares of the frame are sums of those of boxes times this
  [[nodiscard]] bool is_whole() const { return bricks == BrickBox{}; }
};

// How frames are cut into cells, and how many boxes are picked.
struct MeasuredCells {
  int bricks = 2;                                              // along an axis, or one more
  size_t fewest = 12;                                          // of a frame that is not taken whole
  size_t fewest_boxes = 6, most_boxes = 9, most_of_still = 20; // of a frame; of the only one
  int64_t least_edge = 8;                                      // of a box, in samples
  int64_t planes_apart = 8;                                    // of those that are looked at for bends
};

// The one box that is all of a frame.
[[nodiscard]] MeasuredBox whole_frame(const Lattice4& lattice);
// Boxes of the frame of that number: others of another one. A frame of few cells is taken whole. earlier:
// frames before it, where any are known. Where cells are single bricks, there is one division.
[[nodiscard]] std::vector<MeasuredBox> choose_measured_boxes(const Lattice4& lattice, uint32_t frame,
                                                             std::span<const FrameBox> boxes, double air,
                                                             EarlierFrames* earlier = nullptr,
                                                             const MeasuredCells& kind = {});
// The samples around which a kernel stays within these bricks; those of a box that was chosen.
[[nodiscard]] Region samples_inside(const Lattice4& lattice, const BrickBox& bricks);

// Errors of the boxes of a frame. Numbers of samples and the largest difference are those of the boxes, sums
// of squares are such that mean squares are those of the frame.
class BoxErrors {
 public:
  void add(const SampleErrors& errors, double weight);
  [[nodiscard]] SampleErrors of_frame() const;

 private:
  // Weighed by what boxes stand for.
  struct Mean {
    double squares = 0, count = 0;
    void add(const ErrorSum& errors, double times);
    [[nodiscard]] double squares_of(uint64_t samples) const;
  };
  SampleErrors sum_;
  double squares_ = 0, bare_ = 0; // means
  Mean non_air_;
};

} // namespace bccsplat
