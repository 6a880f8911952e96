// What a motion trail is made of: the slices of an interval and their shares.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "base/context.h"
#include "render/transfer_function.h"
#include "slice/coefficients.h"
#include "slice/slice.h"
#include "splat/points.h"
#include "splat/stack.h"

namespace bccsplat {

enum class TrailContent : uint8_t { classified = 1, mean = 2, maximum = 3 };

struct TrailOptions {
  TrailContent content = TrailContent::classified;
  std::array<double, 2> interval{0, 0}; // frames relative to the slice's, clipped to the series
  int samples = 0;                      // stills per sub-interval; 0: one per lattice layer, 4 to 64
  int intervals = 1;                    // sub-intervals, each of a colour of its own when more than one
};

struct TrailSlice {
  Slice slice;
  SplatPoints points;
  double weight = 1; // of its extinction; a trail's sum to 1
  int interval = 0;  // sub-interval it belongs to
};

// classified: stills at the midpoints of equal parts, each with its share (midpoint rule: second order in the
// parts). mean, maximum: one slice per sub-interval. An interval that clips to nothing gives no slices.
// Throws unsupported for slices that are not time slices.
[[nodiscard]] std::vector<TrailSlice> make_trail(const Coefficients& coefficients, const Slice& slice,
                                                 const TrailOptions& options, const Context& context);

// The function with every colour replaced.
[[nodiscard]] TransferFunction tinted(const TransferFunction& function, const Vec3& color);
// Colours of sub-intervals: from blue at the interval's begin over white to orange at its end.
[[nodiscard]] Vec3 ramp_color(int interval, int intervals);

} // namespace bccsplat
