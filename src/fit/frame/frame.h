// SPDX-License-Identifier: Apache-2.0
// One frame of a Cartesian series as its owner holds it: dense boxes of any numeric type, air between them.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "points/values.h"

namespace bccsplat {

// A dense box of one frame; what no box covers is air. Boxes of a frame must not overlap (where they do, the
// later one counts).
struct FrameBox {
  const void* data = nullptr;             // the sample at `begin`; borrowed, any alignment
  SourceType type = SourceType::f32;      // not unknown
  std::array<int64_t, 3> begin{0, 0, 0};  // source index (x, y, z)
  std::array<int64_t, 3> dims{0, 0, 0};   // samples; begin + dims within the frame
  std::array<int64_t, 3> stride{0, 0, 0}; // bytes between neighbours; all 0: packed, x fastest
};

// What becomes of a NaN or infinity of the source. The numbers are those of the C ABI.
enum class NonFinite : uint8_t {
  error = 1, // Code::nonfinite_value, with frame and voxel in the text
  hole = 2,  // missing data: filled smoothly, marked as a hole on the lattice
  clamp = 3  // NaN: air; infinities: the end of the channel's range
};

// A box of source samples, half-open.
struct Region {
  std::array<int64_t, 3> begin{}, end{};
  [[nodiscard]] int64_t length(size_t axis) const { return end[axis] - begin[axis]; }
  [[nodiscard]] bool empty() const { return length(0) <= 0 || length(1) <= 0 || length(2) <= 0; }
  [[nodiscard]] uint64_t samples() const {
    return empty() ? 0 : static_cast<uint64_t>(length(0)) * length(1) * length(2);
  }
  [[nodiscard]] Region cut(const Region& other) const;
  // Returns the least region that has both, either of which may be empty.
  [[nodiscard]] Region joined(const Region& other) const;
  bool operator==(const Region&) const = default;
};

// The boxes of one frame, with the air value and what replaces NaN and infinities. What no box covers is air
// where the frame is given, and not known elsewhere.
class Frame {
 public:
  // Throws invalid_argument, naming `what`, when a box does not fit the frame.
  Frame(std::span<const FrameBox> boxes, const std::array<int64_t, 3>& dims, double air,
        const std::string& what);

  [[nodiscard]] const std::array<int64_t, 3>& dims() const { return dims_; }
  [[nodiscard]] double air() const { return air_; }
  [[nodiscard]] std::span<const FrameBox> boxes() const { return boxes_; }
  // The samples that are given; the others are not read. All of them until a part of them is named.
  [[nodiscard]] const Region& given() const { return given_; }
  void set_given(const Region& region) { given_ = region; }
  [[nodiscard]] Region region(const FrameBox& box) const;
  [[nodiscard]] const std::byte* sample(const FrameBox& box, int64_t x, int64_t y, int64_t z) const;

  // Makes NaN read as air from now on, and infinities as `low` and `high`, all relative to air.
  void clamp(float low, float high);
  // Replaces the samples of `region` by `values` (relative to air, x fastest) from now on.
  void patch(const Region& region, std::vector<float> values);

  // The boxes that touch a region, rising.
  [[nodiscard]] std::vector<uint32_t> boxes_in(const Region& region) const;
  // Samples relative to air: out[z*plane + y*row + x], counted from region.begin. The region lies in what is
  // given of the frame (else Code::internal), and `boxes` are the boxes in it, or in a larger region.
  void read(std::span<const uint32_t> boxes, const Region& region, float* out, int64_t row,
            int64_t plane) const;

 private:
  // The part of a row of `box` that lies in `part`.
  void read_row(const FrameBox& box, const Region& part, int64_t y, int64_t z, float* out) const;

  std::vector<FrameBox> boxes_; // strides filled in
  std::array<int64_t, 3> dims_;
  Region given_;
  double air_;
  // Boxes by the cells of a coarse grid they touch: cell c has members_[cell_begin_[c] .. cell_begin_[c +
  // 1]).
  std::array<int64_t, 3> cells_{1, 1, 1};
  std::vector<uint32_t> cell_begin_, members_;
  bool clamps_ = false;
  float clamp_low_ = 0, clamp_high_ = 0;
  Region patch_region_;
  std::vector<float> patch_;
};

} // namespace bccsplat
