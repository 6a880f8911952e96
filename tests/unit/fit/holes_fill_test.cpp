// SPDX-License-Identifier: Apache-2.0
// Missing data: the fill is smooth, what is known stays, and the lattice knows what is missing.
#include <gtest/gtest.h>

#include "fit/resample/holes.h"
#include "formats/bcc4/coding/mask_runs.h"
#include "tests/support/larger.h"
#include "tests/unit/fit/fit_series.h"

namespace bccsplat::test {
namespace {

TEST(HolesFill, ConstantIsFilledWithItself) {
  Bench bench(2);
  std::vector<float> values(30 * 20 * 10, 4.5f);
  std::vector<uint8_t> missing(values.size(), 0);
  std::mt19937 random(1);
  for (size_t i = 0; i < values.size(); ++i)
    if (random() % 5) missing[i] = 1, values[i] = NAN;
  fill_missing(values, missing, {30, 20, 10}, bench.context);
  for (const float v : values) EXPECT_FLOAT_EQ(v, 4.5f);
}

TEST(HolesFill, StaysWithinTheKnownValuesAndCloseToASmoothField) {
  Bench bench;
  const std::array<int64_t, 3> n{32, 28, 24};
  const auto field = [](double x, double y, double z) {
    return std::sin(0.15 * x) + std::cos(0.1 * y + 0.12 * z);
  };
  std::vector<float> truth, values;
  std::vector<uint8_t> missing;
  double low = 9, high = -9;
  for (int64_t z = 0; z < n[2]; ++z)
    for (int64_t y = 0; y < n[1]; ++y)
      for (int64_t x = 0; x < n[0]; ++x) {
        truth.push_back(static_cast<float>(field(double(x), double(y), double(z))));
        missing.push_back(std::hypot(double(x - 16), double(y - 14), double(z - 12)) < 7);
        values.push_back(missing.back() ? NAN : truth.back());
        if (!missing.back())
          low = std::min(low, double(truth.back())), high = std::max(high, double(truth.back()));
      }
  fill_missing(values, missing, n, bench.context);
  double worst_step = 0;
  for (size_t i = 0; i < values.size(); ++i) {
    ASSERT_TRUE(missing[i] || values[i] == truth[i]);
    ASSERT_GE(values[i], low - 1e-6);
    ASSERT_LE(values[i], high + 1e-6);
    ASSERT_NEAR(values[i], truth[i], 0.4);
    if (i % 32) worst_step = larger(worst_step, std::fabs(double(values[i]) - double(values[i - 1])));
  }
  // No false edge: neighbours differ no more than twice as much as in the field itself (0.15).
  EXPECT_LT(worst_step, 0.3);
}

TEST(HolesFill, ThreadsChangeNothing) {
  const std::array<int64_t, 3> n{80, 60, 50};
  const Series s = noise({80, 60, 50, 1}, 2);
  std::vector<uint8_t> missing;
  for (size_t i = 0; i < s.values.size(); ++i) missing.push_back(i % 7 < 5);
  std::vector<float> one = s.values, four = s.values;
  Bench a(1), b(4);
  fill_missing(one, missing, n, a.context);
  fill_missing(four, missing, n, b.context);
  EXPECT_EQ(one, four);
}

// Data in the left half of a frame of so many samples, and in some places to the right of it.
struct HalfMissing {
  std::array<int64_t, 3> dims;
  std::vector<float> values;
  std::vector<uint8_t> missing;
  [[nodiscard]] size_t at(int64_t x, int64_t y, int64_t z) const { return (z * dims[1] + y) * dims[0] + x; }
};
HalfMissing half_missing(std::array<int64_t, 3> n,
                         const std::function<float(int64_t, int64_t, int64_t)>& value,
                         bool scattered = true) {
  HalfMissing out{n, {}, {}};
  for (int64_t z = 0; z < n[2]; ++z)
    for (int64_t y = 0; y < n[1]; ++y)
      for (int64_t x = 0; x < n[0]; ++x) {
        const bool there = x < n[0] / 2 || (scattered && (x * 5 + y * 3 + z * 7) % 41 == 0 && y < n[1] / 2);
        out.missing.push_back(there ? 0 : 1);
        out.values.push_back(there ? value(x, y, z) : NAN);
      }
  return out;
}

TEST(HolesFill, ABoundedFillContinuesDataAndEndsInAir) {
  for (const double samples : {3.0, 12.0, 20.0}) {
    const FillReach reach = FillReach::of(samples);
    Bench bench;
    HalfMissing all = half_missing(
        {200, 24, 18}, [](int64_t, int64_t, int64_t) { return 7.25f; }, false);
    fill_missing(all.values, all.missing, all.dims, bench.context, {}, reach);
    for (int64_t x = 0; x < 200; ++x) {
      const float v = all.values[all.at(x, 11, 7)];
      if (x < 100 + static_cast<int64_t>(samples) / 2) {
        EXPECT_NEAR(v, 7.25, x < 100 ? 0 : x == 100 ? 0.005 : 0.4) << x; // some air comes in
      } else if (x >= 100 + reach.samples()) {
        EXPECT_EQ(v, 0) << x;
      }
      EXPECT_GE(v, 0);
      EXPECT_LE(v, all.values[all.at(std::max<int64_t>(x, 1) - 1, 11, 7)] + 1e-5f) << x;
    }
  }
}

TEST(HolesFill, ABoundedFillOfABoxIsThatOfTheFrame) {
  constexpr std::array<int64_t, 3> n{131, 97, 90};
  for (const double samples : {3.0, 20.0}) {
    const FillReach reach = FillReach::of(samples);
    std::mt19937 random(3);
    std::uniform_real_distribution<float> uniform(-1, 1);
    const HalfMissing frame = half_missing(n, [&](int64_t, int64_t, int64_t) { return uniform(random); });
    Bench one(1), two(2);
    std::vector<float> whole = frame.values;
    fill_missing(whole, frame.missing, n, one.context, {}, reach);
    size_t compared = 0;
    // Boxes at the ends of the frame and within it.
    for (const Region& own : {Region{{40, 30, 35}, {44, 33, 36}}, Region{{64, 0, 60}, {80, 20, 90}},
                              Region{{100, 60, 0}, {131, 97, 9}}, Region{{64, 61, 40}, {65, 64, 43}}}) {
      Region given;
      for (size_t a = 0; a < 3; ++a) {
        given.begin[a] = std::max<int64_t>(own.begin[a] - reach.samples(), 0) / reach.cell() * reach.cell();
        given.end[a] =
            std::min((own.end[a] + reach.samples() + reach.cell() - 1) / reach.cell() * reach.cell(), n[a]);
      }
      std::vector<float> part;
      std::vector<uint8_t> missing;
      for (int64_t z = given.begin[2]; z < given.end[2]; ++z)
        for (int64_t y = given.begin[1]; y < given.end[1]; ++y)
          for (int64_t x = given.begin[0]; x < given.end[0]; ++x)
            part.push_back(frame.values[frame.at(x, y, z)]),
                missing.push_back(frame.missing[frame.at(x, y, z)]);
      const std::array<int64_t, 3> m{given.length(0), given.length(1), given.length(2)};
      ASSERT_LT(part.size(), whole.size());
      fill_missing(part, missing, m, two.context, {}, reach);
      for (int64_t z = own.begin[2]; z < own.end[2]; ++z)
        for (int64_t y = own.begin[1]; y < own.end[1]; ++y)
          for (int64_t x = own.begin[0]; x < own.end[0]; ++x, ++compared)
            ASSERT_EQ(part[((z - given.begin[2]) * m[1] + y - given.begin[1]) * m[0] + x - given.begin[0]],
                      whole[frame.at(x, y, z)])
                << samples << ": " << x << " " << y << " " << z;
    }
    EXPECT_GT(compared, 10000u);
  }
}

// A wave of values around 3 (air is 0) in which some voxels are NaN.
Series with_holes(const std::function<bool(double, double, double, double)>& missing) {
  return Series({26, 22, 24, 8}, [&](double x, double y, double z, double t) {
    return missing(x, y, z, t) ? double(NAN) : 3 + std::sin(0.3 * x + 0.2 * y - 0.25 * z + 0.2 * t);
  });
}

TEST(HolesFill, SitesNearestToMissingVoxelsAreHoles) {
  const auto missing = [](double x, double y, double z, double t) {
    return (std::hypot(x - 12, y - 9, z - 13) < 4 && t > 1 && t < 6) || (x == 0 && t == 3);
  };
  const Series s = with_holes(missing);
  FitOptions o = options_for(s);
  o.nonfinite = NonFinite::hole;
  const Fitted f = run_fit(o, s, 2);
  const Series smooth = with_holes([](double, double, double, double) { return false; });
  const auto reference = reference_layers(f.report.lattice, smooth);
  const Lattice4& l = f.report.lattice;
  uint64_t holes = 0;
  for (int32_t m = 0; m < l.layers(); ++m) {
    const BrickLayer& layer = f.layers[m];
    const Int3 n = layer.dims();
    const auto nearest = [](double p, double end) { return std::min(std::floor(p + 0.5), end); };
    const double t = nearest(l.layer_frame(m), 7);
    for (int32_t k = 0; k < n[2]; ++k)
      for (int32_t j = 0; j < n[1]; ++j)
        for (int32_t i = 0; i < n[0]; ++i) {
          const Vec3 p = l.site_position(l.coset(m), {i, j, k});
          const bool hole = missing(nearest(p[0], 25), nearest(p[1], 21), nearest(p[2], 23), t);
          const Brick* brick = layer.brick(i / 16, j / 16, k / 16);
          ASSERT_TRUE(brick);
          const int site = (k % 16 * 16 + j % 16) * 16 + i % 16;
          ASSERT_EQ(brick->is_hole(site), hole) << m << ": " << i << " " << j << " " << k;
          ASSERT_TRUE(brick->kept[site / 16] >> (site % 16) & 1);
          holes += hole;
          // The fill is close to what was there, so nothing false reaches the sites around.
          const size_t index = (k * n[1] + j) * n[0] + i;
          ASSERT_NEAR(layer.value(i, j, k), reference[m][index], 0.45);
        }
  }
  EXPECT_GT(holes, 0u);
  EXPECT_EQ(f.report.channels[0].holes, holes);
  EXPECT_EQ(f.report.channels[0].samples.count(), f.report.channels[0].sites_kept - holes);
  uint64_t nonfinite = 0;
  for (const float v : s.values) nonfinite += !std::isfinite(v);
  EXPECT_EQ(f.report.channels[0].nonfinite, nonfinite);
}

TEST(HolesFill, MasksTellWhatIsMissingAndSitesAreNotMarked) {
  const auto missing = [](double x, double y, double z, double t) {
    return (std::hypot(x - 12, y - 9, z - 13) < 4 && t > 1 && t < 6) || (x == 0 && t == 3);
  };
  const Series s = with_holes(missing);
  FitOptions o = options_for(s);
  o.nonfinite = NonFinite::hole;
  const Fitted marked = run_fit(o, s);
  o.masks = true;
  o.mask_reach = 30; // no site is further from data
  std::vector<std::vector<std::byte>> runs(s.dims[3]);
  const Fitted f =
      run_fit(o, s, 1, [&](int, uint32_t frame, std::vector<std::byte> of) { runs[frame] = std::move(of); });
  ASSERT_EQ(f.layers.size(), marked.layers.size());
  for (size_t m = 0; m < f.layers.size(); ++m) {
    EXPECT_EQ(f.dense(static_cast<int32_t>(m)), marked.dense(static_cast<int32_t>(m)));
    for (size_t slot = 0; slot < f.layers[m].brick_slots(); ++slot)
      EXPECT_FALSE(f.layers[m].brick(slot)->hole);
  }
  // What fills holes is no sample that counts.
  EXPECT_EQ(f.report.channels[0].holes, 0u);
  EXPECT_EQ(f.report.channels[0].samples.count(), marked.report.channels[0].samples.count());
  const uint64_t voxels = s.frame_samples();
  for (uint32_t t = 0; t < s.dims[3]; ++t) {
    std::vector<bool> none(voxels);
    if (!runs[t].empty())
      read_mask_runs(runs[t], voxels, 0, [&](uint64_t begin, uint64_t end) {
        for (uint64_t v = begin; v < end; ++v) none[v] = true;
      });
    for (uint64_t v = 0; v < voxels; ++v) ASSERT_EQ(none[v], std::isnan(s.frame(t)[v])) << t << " " << v;
  }
}

TEST(HolesFill, NothingIsStoredFarFromData) {
  // Land for x < 20, but for one frame; beyond an end of the frame there is nothing.
  const auto land = [](double x, double, double, double t) { return x < 20 && t != 7; };
  const Series s = with_holes(land);
  FitOptions o = options_for(s);
  o.nonfinite = NonFinite::hole, o.masks = true, o.mask_reach = 4;
  const Fitted f = run_fit(o, s, 1, [](int, uint32_t, const std::vector<std::byte>&) {});
  const Lattice4& l = f.report.lattice;
  const double reach = std::ceil(4 * l.space_step[0] + 0.5);
  size_t left_out = 0, kept = 0;
  for (int32_t m = 0; m < l.layers(); ++m) {
    const Int3 n = f.layers[m].dims();
    for (int32_t i = 0; i < n[0]; ++i) {
      const double x = std::floor(l.site_position(l.coset(m), {i, 0, 0})[0] + 0.5);
      const Brick* brick = f.layers[m].brick(i / 16, 0, 0);
      const bool is_kept = brick && (brick->kept[5 * 16 + 5] >> (i % 16) & 1);
      if (x >= 20 - reach) {
        EXPECT_TRUE(is_kept) << m << " " << i;
        ++kept;
      } else if (l.layer_frame(m) < 2) { // the filter in time does not reach frame 7
        EXPECT_FALSE(is_kept) << m << " " << i;
        ++left_out;
      } else if (l.layer_frame(m) > 6) {
        EXPECT_TRUE(is_kept) << m << " " << i;
      }
    }
  }
  EXPECT_GT(left_out, 20u);
  EXPECT_GT(kept, 20u);
  // Left out is no error of coding.
  EXPECT_LT(f.report.channels[0].coding_max, 1e-5);
}

TEST(HolesFill, AMissingFrameHoldsItsNeighbour) {
  for (const double gone : {0.0, 4.0, 7.0}) {
    const Series s = with_holes([&](double, double, double, double t) { return t == gone; });
    FitOptions o = options_for(s);
    o.nonfinite = NonFinite::hole;
    const Fitted f = run_fit(o, s);
    for (int32_t m = 0; m < f.report.lattice.layers(); ++m) {
      const bool hole = std::min(std::floor(f.report.lattice.layer_frame(m) + 0.5), 7.0) == gone;
      const BrickLayer& layer = f.layers[m];
      EXPECT_EQ(layer.brick(0)->is_hole(0), hole);
      for (const float v : layer_to_dense(layer))
        ASSERT_NEAR(v, 3, 1.3); // no dip to air in or around the gap
    }
  }
}

TEST(HolesFill, NothingButHoles) {
  const Series s = with_holes([](double, double, double, double) { return true; });
  FitOptions o = options_for(s);
  o.nonfinite = NonFinite::hole;
  const Fitted f = run_fit(o, s);
  EXPECT_EQ(f.report.channels[0].holes, static_cast<uint64_t>(f.report.lattice.sites()));
  EXPECT_EQ(f.report.channels[0].samples.count(), 0u);
  EXPECT_EQ(f.report.channels[0].source_range, Range{});
}

TEST(HolesFill, PoliciesForWhatIsNotFinite) {
  Series s =
      with_holes([](double x, double y, double z, double t) { return x == 3 && y == 4 && z == 5 && t == 6; });
  FitOptions o = options_for(s);
  try {
    (void)run_fit(o, s);
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), Code::nonfinite_value);
    EXPECT_NE(e.message().find("frame 6"), std::string::npos);
    EXPECT_NE(e.message().find("(3, 4, 5)"), std::string::npos);
  }
  // Clamped on the lattice that keeps every sample: NaN is air, infinities the ends of the range.
  s.values[100] = INFINITY;
  s.values[101] = -INFINITY;
  o.lattice = LatticeKind::cc;
  o.nonfinite = NonFinite::clamp;
  o.channels[0].range = Range{-2, 9};
  const Fitted f = run_fit(o, s);
  EXPECT_EQ(f.dense(0)[100], 9.0f);
  EXPECT_EQ(f.dense(0)[101], -2.0f);
  EXPECT_EQ(f.layers[6].value(3, 4, 5), 0.0f);
  EXPECT_EQ(f.report.channels[0].nonfinite, 3u);
  EXPECT_EQ(f.report.channels[0].holes, 0u);
  o.channels[0].range.reset();
  const Fitted g = run_fit(o, s);
  EXPECT_EQ(static_cast<double>(g.dense(0)[100]), g.report.channels[0].frames[0].high);
}

} // namespace
} // namespace bccsplat::test
