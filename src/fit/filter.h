// One-dimensional resampling: source samples at 0 .. n-1 -> values at equally spaced planes.
#pragma once

#include <cstdint>
#include <vector>

namespace bccsplat {

// Numbers of the C ABI.
enum class Filter : uint8_t {
  kaiser8 = 1, // Kaiser-windowed sinc, 8 taps, beta 5.5
  kaiser6 = 2, // the same with 6 taps, beta 5
  bspline3 = 3 // interpolating cubic B-spline, cut where its weights fall below 2e-6 (20 taps)
};

// Plane h takes source samples first[h] .. first[h] + taps - 1 with weight[h * taps ..]; indices outside 0 ..
// n-1 mean the mirror image. The weights of a plane sum to 1.
struct FilterTable {
  int taps = 1;
  std::vector<int64_t> first;
  std::vector<float> weight;
};

// Samples before and after a position that its value can depend on. `widening` >= 1 stretches the filter, so
// that it passes only what a lattice coarser than the source by that factor can hold.
[[nodiscard]] int filter_reach(Filter filter, double widening);
// Planes begin .. begin + count - 1 at (plane * step) source samples.
[[nodiscard]] FilterTable filter_table(Filter filter, double step, double widening, int64_t begin,
                                       int64_t count);
// Where the mirror image puts index i of an axis of n samples.
[[nodiscard]] int64_t mirror_index(int64_t i, int64_t n);

} // namespace bccsplat
