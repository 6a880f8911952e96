// SPDX-License-Identifier: Apache-2.0
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tests/bench/splat/splat_floor.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <random>
#include <vector>

#include "tests/bench/report.h"
#include "tests/bench/splat/splat_floor.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat::bench {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// `rounds` times 12 chains of 8 multiply-adds from different starts; returns something that depends on all of
// them.
float Chains(const float* start, int rounds, size_t& operations) {
  const hn::CappedTag<float, 16> d;
  const auto a = hn::Set(d, start[12]), b = hn::Set(d, start[13]);
  const auto from = [&](int n) HWY_ATTR { return hn::Set(d, start[n]); };
  auto x0 = from(0), x1 = from(1), x2 = from(2), x3 = from(3), x4 = from(4), x5 = from(5);
  auto x6 = from(6), x7 = from(7), x8 = from(8), x9 = from(9), x10 = from(10), x11 = from(11);
  for (int n = 0; n < rounds; ++n)
    for (int i = 0; i < 8; ++i) {
      x0 = hn::MulAdd(x0, a, b), x1 = hn::MulAdd(x1, a, b), x2 = hn::MulAdd(x2, a, b);
      x3 = hn::MulAdd(x3, a, b), x4 = hn::MulAdd(x4, a, b), x5 = hn::MulAdd(x5, a, b);
      x6 = hn::MulAdd(x6, a, b), x7 = hn::MulAdd(x7, a, b), x8 = hn::MulAdd(x8, a, b);
      x9 = hn::MulAdd(x9, a, b), x10 = hn::MulAdd(x10, a, b), x11 = hn::MulAdd(x11, a, b);
    }
  operations = static_cast<size_t>(rounds) * 8 * 12 * hn::Lanes(d);
  const auto s0 = hn::Add(hn::Add(x0, x1), hn::Add(x2, x3)), s1 = hn::Add(hn::Add(x4, x5), hn::Add(x6, x7));
  return hn::GetLane(
      hn::SumOfLanes(d, hn::Add(hn::Add(s0, s1), hn::Add(hn::Add(x8, x9), hn::Add(x10, x11)))));
}

// Adds 1 to `rows` rows of `floats` floats from each start.
void Update(const int* start, size_t count, int rows, int floats, int pitch, float* ring) {
  const hn::CappedTag<float, 16> d;
  const auto one = hn::Set(d, 1.0f);
  const auto lanes = static_cast<int>(hn::Lanes(d));
  for (size_t n = 0; n < count; ++n) {
    float* row = ring + start[n];
    for (int r = 0; r < rows; ++r, row += pitch)
      for (int f = 0; f < floats; f += lanes) hn::StoreU(hn::Add(hn::LoadU(d, row + f), one), d, row + f);
  }
}

} // namespace HWY_NAMESPACE
} // namespace bccsplat::bench
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat::bench {
HWY_EXPORT(Chains);
HWY_EXPORT(Update);

double fma_peak() {
  double best = 0;
  volatile float sink = 0;
  std::array<float, 14> start{};
  for (size_t n = 0; n < 12; ++n) start[n] = 1 + 0.1f * static_cast<float>(n);
  start[12] = 0.999f, start[13] = 1e-3f;
  for (int repeat = 0; repeat < 7; ++repeat) {
    size_t operations = 0;
    const double seconds =
        cpu_seconds([&] { sink = sink + HWY_DYNAMIC_DISPATCH(Chains)(start.data(), 200000, operations); });
    best = std::max(best, static_cast<double>(operations) / seconds);
  }
  return best;
}

double update_peak(int width) {
  constexpr int side = 48; // pixels of the ring: 36 KB
  std::vector<float> ring(side * side * 4 + 64);
  std::vector<int> start(4096);
  std::mt19937 random(3);
  std::uniform_int_distribution<int> at(0, side - width);
  for (int& s : start) s = 4 * (at(random) * side + at(random));
  double best = 0;
  for (int repeat = 0; repeat < 7; ++repeat) {
    const double seconds = cpu_seconds([&] {
      for (int n = 0; n < 64; ++n)
        HWY_DYNAMIC_DISPATCH(Update)(start.data(), start.size(), width, 4 * width, 4 * side, ring.data());
    });
    best = std::max(best, 64.0 * static_cast<double>(start.size()) * width * width * 4 / seconds);
  }
  return best;
}

} // namespace bccsplat::bench
#endif
