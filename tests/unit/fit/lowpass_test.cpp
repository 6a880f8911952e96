// SPDX-License-Identifier: Apache-2.0
// The low-pass of the 24-cell: products of cosines that fit the mirrored domain are its eigenfunctions, so
// one gain must hold at every sample, ends included.
#include <cstring>

#include <gtest/gtest.h>

#include "fit/resample/lowpass.h"
#include "tests/support/larger.h"
#include "tests/unit/fit/fit_series.h"

namespace bccsplat::test {
namespace {

constexpr LatticeScales unscaled{1, 1, 1, 1};

Lattice4 lattice_for(const Series& s, const LatticeScales& scales = unscaled) {
  return Lattice4::fit(LatticeKind::d4star, s.dims, scales);
}

Series filtered(const Series& s, const Lattice4& lattice, int threads = 1) {
  Bench bench(threads);
  const Context context = bench.context;
  Lowpass lowpass(lattice, 0);
  Series out;
  out.dims = s.dims;
  const std::array<int64_t, 3> n{s.dims[0], s.dims[1], s.dims[2]};
  const auto sink = [&](const Frame& frame, const HoleMap&) {
    std::vector<float> v(s.frame_samples());
    const Region all{{0, 0, 0}, n};
    frame.read(frame.boxes_in(all), all, v.data(), n[0], n[0] * n[1]);
    out.values.insert(out.values.end(), v.begin(), v.end());
  };
  for (uint32_t t = 0; t < s.dims[3]; ++t) {
    const FrameBox box = s.box(t);
    const Frame frame({&box, 1}, n, 0, "test");
    lowpass.add(&frame, {}, sink, context);
  }
  lowpass.finish(sink, context);
  EXPECT_EQ(out.values.size(), s.values.size());
  return out;
}

// f: fractions of the Nyquist frequency; f * (n - 1) must be whole.
Series wave(const std::array<uint32_t, 4>& dims, const std::array<double, 4>& f) {
  const double pi = std::numbers::pi;
  return Series(dims, [&](double x, double y, double z, double t) {
    return std::cos(pi * f[0] * x) * std::cos(pi * f[1] * y) * std::cos(pi * f[2] * z) *
           std::cos(pi * f[3] * t);
  });
}

// The gain at the first sample; any other must have the same.
double gain(const std::array<uint32_t, 4>& dims, const std::array<double, 4>& f,
            const LatticeScales& scales = unscaled) {
  const Series s = wave(dims, f);
  const Series out = filtered(s, lattice_for(s, scales));
  const double g = out.values[0];
  double worst = 0;
  for (size_t i = 0; i < s.values.size(); ++i)
    worst = larger(worst, std::fabs(out.values[i] - g * s.values[i]));
  EXPECT_LT(worst, 1e-5);
  return g;
}

double decibel(double g) { return 20 * std::log10(std::max(std::fabs(g), 1e-9)); }

constexpr std::array<uint32_t, 4> wave_dims{21, 11, 11, 21};

TEST(Lowpass, PassesWhatLiesInTheCell) {
  const std::array<double, 4> inside[] = {{.5, .5, 0, 0},     {.5, 0, 0, .5},  {.7, 0, 0, 0},
                                          {0, 0, 0, .7},      {.4, .4, .4, 0}, {0, .5, .5, 0},
                                          {.35, .3, .4, .35}, {.5, 0, .5, 0}};
  for (const auto& f : inside)
    EXPECT_LT(std::fabs(decibel(gain(wave_dims, f))), 0.1) << f[0] << f[1] << f[2] << f[3];
  EXPECT_NEAR(gain(wave_dims, {1, 0, 0, 0}), 1, 0.02); // a corner of the cell: sum 1
}

TEST(Lowpass, StopsTheCornersOfTheCube) {
  const std::array<double, 4> outside[] = {{1, 1, 0, 0},   {1, 0, 0, 1},   {0, 1, 1, 0},    {0, 0, 1, 1},
                                           {.9, .9, 0, 0}, {.9, 0, 0, .9}, {1, .8, 0, 0},   {0, .8, 0, 1},
                                           {1, 1, 1, 1},   {0, .9, .9, 0}, {.9, 0, .9, .9}, {1, 0, .8, 0}};
  for (const auto& f : outside) EXPECT_LT(decibel(gain(wave_dims, f)), -30) << f[0] << f[1] << f[2] << f[3];
}

TEST(Lowpass, CellShrinksWithTheLattice) {
  constexpr LatticeScales coarse{2, 2, 2, 2};
  EXPECT_LT(std::fabs(decibel(gain(wave_dims, {.25, .2, 0, .25}, coarse))), 0.1);
  EXPECT_LT(decibel(gain(wave_dims, {.5, .5, 0, 0}, coarse)), -30);
  EXPECT_LT(decibel(gain(wave_dims, {.5, 0, 0, .5}, coarse)), -30);
}

TEST(Lowpass, CellIsOfTheDistancesOfItsAxes) {
  constexpr LatticeScales scales{0.7, 0.7, 1, 2.3};
  const std::array<double, 4> inside[] = {
      {1, .9, 0, 0}, {.9, 0, .4, 0}, {.9, 0, 0, .2}, {0, .7, 0, .25}, {0, 0, .3, .3}};
  for (const auto& f : inside)
    EXPECT_LT(std::fabs(decibel(gain(wave_dims, f, scales))), 0.1) << f[0] << f[1] << f[2] << f[3];
  const std::array<double, 4> outside[] = {{1, 0, 0, .6}, {0, .7, 0, .7}, {.5, 0, 0, .7}, {0, 0, 1, .4}};
  for (const auto& f : outside)
    EXPECT_LT(decibel(gain(wave_dims, f, scales)), -30) << f[0] << f[1] << f[2] << f[3];
}

TEST(Lowpass, ShortAxesMirrorAsOftenAsNeeded) {
  EXPECT_LT(decibel(gain({3, 2, 1, 2}, {1, 0, 0, 1})), -30);
  EXPECT_LT(std::fabs(decibel(gain({3, 2, 1, 3}, {.5, 0, 0, .5}))), 0.1);
  EXPECT_LT(decibel(gain({5, 5, 1, 1}, {1, 1, 0, 0})), -30); // static: pairs in space
  EXPECT_LT(std::fabs(decibel(gain({5, 5, 3, 1}, {.5, .5, 0, 0}))), 0.1);
}

TEST(Lowpass, ConstantsStayExactly) {
  for (const double v : {0.1, -3e30, 3e38}) {
    const Series s({9, 5, 4, 6}, [&](double, double, double, double) { return v; });
    EXPECT_EQ(filtered(s, lattice_for(s)).values, s.values);
  }
}

TEST(Lowpass, SameBitsReversedAndForAnyThreads) {
  const Series s = noise({13, 9, 7, 19}, 3);
  const Series out = filtered(s, lattice_for(s));
  EXPECT_EQ(filtered(s, lattice_for(s), 3).values, out.values);
  Series turned = s; // all four axes
  std::reverse(turned.values.begin(), turned.values.end());
  Series back = filtered(turned, lattice_for(s));
  std::reverse(back.values.begin(), back.values.end());
  EXPECT_EQ(back.values, out.values);
}

TEST(Lowpass, FitIsThatOfTheFilteredFrames) {
  const Series s = noise({13, 9, 7, 27}, 4);
  FitOptions o = options_for(s);
  const Fitted expected = run_fit(o, filtered(s, lattice_for(s)));
  o.lowpass = true;
  EXPECT_TRUE(identical(run_fit(o, s), expected));
  EXPECT_TRUE(identical(run_fit(o, s, 3), expected));
  o.dims[3] = 0; // their number is not known
  EXPECT_TRUE(identical(run_fit(o, s), expected));
}

TEST(Lowpass, MissingFramesHoldTheirNeighboursAndAreHoles) {
  Series s = noise({8, 7, 6, 12}, 5), filled = s;
  for (const uint32_t t : {0u, 1u, 6u}) {
    const ptrdiff_t n = s.frame_samples();
    std::fill_n(s.values.begin() + t * n, n, NAN);
    std::copy_n(filled.values.begin() + (t == 6 ? 5 : 2) * n, n, filled.values.begin() + t * n);
  }
  FitOptions o = options_for(s);
  o.lowpass = true;
  o.nonfinite = NonFinite::hole;
  const Fitted a = run_fit(o, s), b = run_fit(o, filled);
  EXPECT_GT(a.report.channels[0].holes, 0u);
  for (int32_t m = 0; m < a.report.lattice.layers(); ++m) EXPECT_EQ(a.dense(m), b.dense(m)) << m;
  const Series none({8, 7, 6, 3}, [](double, double, double, double) { return NAN; });
  o.dims = none.dims;
  const FitChannelReport all = run_fit(o, none).report.channels[0];
  EXPECT_EQ(all.holes, all.sites_total);
}

TEST(Lowpass, SparseFramesStaySparse) {
  const Series s({40, 40, 40, 12}, [](double x, double y, double z, double t) {
    const double r = std::hypot(x - 14 - t / 2, y - 20, z - 20);
    return r < 9 ? 0.5 + 0.5 * std::cos(std::numbers::pi * r / 9) : 0.0;
  });
  FitOptions o = options_for(s);
  const uint64_t without = run_fit(o, s).report.channels[0].sites_kept;
  o.lowpass = true;
  const uint64_t with = run_fit(o, s).report.channels[0].sites_kept;
  EXPECT_LT(with, without + without / 10);
  EXPECT_GT(with, without - without / 10);
}

TEST(Lowpass, IsNotForCartesianLattices) {
  const Series s = noise({4, 4, 4, 4}, 6);
  FitOptions o = options_for(s, LatticeKind::cc);
  o.lowpass = true;
  EXPECT_THROW(run_fit(o, s), Error);
}

} // namespace
} // namespace bccsplat::test
