// SPDX-License-Identifier: Apache-2.0
// Integrals of the transfer function over the value, for segments in which the value runs through more of the
// function than one entry tells (pre-integrated classification: Engel, Kraus, Ertl 2001, section 3.2, in its
// one-dimensional form: the mean of extinction and emission between two values is the difference of two
// integrals over the difference of the values).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace bccsplat {

// Values are counted in entries of the table, e = (value - low) * scale. Interval j in 1 .. entries - 1 lies
// between the entries j - 1 and j; interval 0 is below the first, interval `entries` above the last, where
// the function does not change.
struct ValueIntegrals {
  // Three per interval: the integral of (colour * extinction, extinction) from entry 0 to base(j), as the sum
  // of two floats, so that differences keep their digits beside anything opaque; and the mean inside.
  std::vector<std::array<float, 4>> part;
  bool split = false; // whether the second of those floats is ever worth adding
  // The integral of e * extinction up to base(j), as two floats.
  std::vector<std::array<float, 4>> moment;
  // The first interval from j on in which anything absorbs; one more than there are intervals.
  std::vector<int32_t> next_visible;
  float first = 0, last_end = 0; // all that absorbs lies between these, in entries

  [[nodiscard]] bool empty() const { return part.empty(); }
  [[nodiscard]] int last() const { return static_cast<int>(next_visible.size()) - 2; } // interval
  [[nodiscard]] static float base(int interval) { return static_cast<float>(std::max(interval - 1, 0)); }
  // The interval that begins at or below e, and the one that ends at or above it.
  [[nodiscard]] int below(float e) const { return within(std::floor(e) + 1); }
  [[nodiscard]] int above(float e) const { return within(std::ceil(e)); }
  // Returns whether anything absorbs between two values, low <= high.
  [[nodiscard]] bool visible(float low, float high) const {
    return next_visible[below(low)] <= std::max(above(high), below(low));
  }

 private:
  [[nodiscard]] int within(float interval) const {
    return static_cast<int>(std::clamp(interval, 0.0f, static_cast<float>(last())));
  }
};

// Half of the segment of a sheet: the value runs linearly from e0 to e1 along `length` (world).
struct HalfClass {
  std::array<float, 3> color{};
  float absorbed = 0, depth = 0; // depth: optical
  float e = 0;                   // mean of what absorbs
};
struct ClassTable;
[[nodiscard]] HalfClass classify_half(const ClassTable& table, float e0, float e1, float length);

// Both halves of a segment, front to back.
struct SegmentClass {
  std::array<float, 3> color{};
  float absorbed = 0, front = 0; // of them, the first half alone
  float depth = 0;               // optical, of both
  float value = 0;
};
[[nodiscard]] SegmentClass classify_segment(const ClassTable& table, const std::array<float, 3>& e,
                                            const std::array<float, 2>& length);

} // namespace bccsplat
