// SPDX-License-Identifier: Apache-2.0
// Axes of space that go round, as longitude does. Nothing tells such a file where an axis begins, and it is
// as good beside the seam as elsewhere, whatever looks at it.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "field/sample_grid.h"
#include "slice/coarsen.h"
#include "slice/extraction.h"
#include "slice/hyperslice.h"
#include "slice/time_slice.h"
#include "splat/points/points.h"
#include "tests/unit/store/written_series.h"

namespace bccsplat {
namespace {

using test::Bench;
using test::expect_sound;
using test::Opened;
using test::Series;
using test::write;

// D4* takes a turn of 48 samples in 68 planes, 34 sites of a coset: the last brick is narrow. Half a turn is
// 34 planes, of the same coset.
constexpr std::array<uint32_t, 4> axis_dims{48, 20, 18, 6};
constexpr int32_t half = 24;

// A cloud across the seam and one half a turn away, unlike their mirror images.
double clouds(double x, double y, double z, double t) {
  double sum = 20;
  for (const double centre : {0.3, 21.0}) {
    const double dx = std::remainder(x - centre - 0.3 * t - 0.2 * (y - 9), axis_dims[0]),
                 dy = y - 9 - 0.3 * t, dz = z - 8;
    sum += (centre < 1 ? 100 : 70) * std::exp(-(dx * dx + dy * dy + dz * dz) / 18);
  }
  return sum;
}

Series turned_clouds(double shift) {
  return Series(axis_dims,
                [&](double x, double y, double z, double t) { return clouds(x + shift, y, z, t); });
}

WriterSettings round_settings() {
  WriterSettings s;
  s.dims = axis_dims, s.turning = {true, false, false}, s.faces = Faces::mirror, s.ends = Ends::mirror;
  s.channels[0].value_type = ValueType::f32;
  return s;
}

// Points with x in [begin, end), which may go on behind the seam.
std::vector<Vec4> points_across(double begin, double end, int count) {
  std::vector<Vec4> points;
  for (int i = 0; i < count; ++i) {
    const auto part = [&](double step, double low, double high) {
      return low + (high - low) * std::fmod(0.5 + i * step, 1.0);
    };
    const double x = part(0.8567, begin, end);
    points.push_back({std::fmod(x + axis_dims[0], axis_dims[0]), part(0.7338, 4, 15), part(0.6288, 4, 13),
                      part(0.5386, 2, 3)});
  }
  return points;
}

// dB.
double axis_snr(Opened& file, double begin, double end) {
  const std::vector<Vec4> points = points_across(begin, end, 4000);
  const auto got = file.at(points);
  double signal = 0, error = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    const Vec4& p = points[i];
    const double truth = clouds(p[0], p[1], p[2], p[3]);
    signal += (truth - 20) * (truth - 20), error += std::pow(got[i] - truth, 2);
  }
  return 10 * std::log10(signal / error);
}

TEST(PeriodicAxis, AWholeNumberOfPlanesIsATurn) {
  for (const LatticeKind kind : {LatticeKind::d4star, LatticeKind::cc})
    for (const uint32_t n : {2u, 3u, 7u, 20u, 360u})
      for (const double scale : {0.4, 1.0, 2.7}) {
        const Lattice4 l =
            Lattice4::fit(kind, {9, n, 9, 5}, {1, scale, 1, 1}, 0, {2, 0, 0}, false, {false, true, false});
        const int32_t planes = l.space.planes(1);
        EXPECT_NEAR(planes * l.space_step[1], n, 1e-12 * n);
        EXPECT_EQ(planes % l.layer_period(), 0);
        EXPECT_EQ(l.space.dims(0)[1], l.space.dims(l.space.cosets() - 1)[1]);
        EXPECT_LE(l.scales()[1], std::max(scale, n / 2.0 / l.space.plane_distance()) + 1e-9);
        for (int c = 0; c < l.space.cosets(); ++c) {
          const int32_t sites = l.space.dims(c)[1];
          EXPECT_EQ(l.space.mirror(1, c, -1), sites - 1);
          EXPECT_EQ(l.space.mirror(1, c, sites), 0);
          EXPECT_EQ(l.space.mirror(1, c, -2 * sites - 1), sites - 1);
        }
        EXPECT_EQ(l.domain_end(1), n);
        EXPECT_EQ(l.domain_end(0), 8);
      }
  EXPECT_THROW(Lattice4::fit(LatticeKind::cc, {1, 9, 9, 5}, {1, 1, 1, 1}, 0, {}, false, {true, false, false}),
               Error);
}

struct AxisWay {
  const char* name;
  std::function<void(WriterSettings&)> set;
  double tolerance = 1e-3;
};

class PeriodicAxisWays : public testing::TestWithParam<AxisWay> {};

TEST_P(PeriodicAxisWays, HasNoBeginning) {
  WriterSettings settings = round_settings();
  GetParam().set(settings);
  std::vector<std::byte> bytes;
  write(settings, turned_clouds(0), bytes);
  Opened a(bytes);
  write(settings, turned_clouds(half), bytes);
  Opened b(bytes);
  ASSERT_TRUE(a.lattice().turns(0));
  ASSERT_EQ(a.lattice(), b.lattice());
  expect_sound(a);
  const Lattice4& lattice = a.lattice();
  if (settings.scales[0] == 1) {
    const int32_t sites = lattice.space.dims(0)[0], by = sites / 2;
    ASSERT_NEAR(lattice.space.plane(0, by) * lattice.space_step[0], half, 1e-9);
    for (int32_t m = 0; m < lattice.layers(); m += 3) {
      const auto one = layer_to_dense(a.samples.read_layer(0, m, {}, a.bench.context)),
                 other = layer_to_dense(b.samples.read_layer(0, m, {}, b.bench.context));
      const size_t row = sites;
      for (size_t i = 0; i < one.size(); ++i)
        ASSERT_NEAR(other[i], one[i / row * row + (i + by) % row], GetParam().tolerance) << m << " " << i;
    }
  }
  for (const double begin : {-2.0, 0.0, 10.0, 22.0}) {
    const std::vector<Vec4> points = points_across(begin, begin + 2, 800);
    std::vector<Vec4> turned = points;
    for (Vec4& p : turned) p[0] = std::fmod(p[0] + axis_dims[0] - half, static_cast<double>(axis_dims[0]));
    const auto x = a.at(points), y = b.at(turned);
    for (size_t i = 0; i < points.size(); ++i) ASSERT_NEAR(x[i], y[i], GetParam().tolerance) << points[i][0];
  }
}

INSTANTIATE_TEST_SUITE_P(
    Ways, PeriodicAxisWays,
    testing::Values(AxisWay{"samples", [](WriterSettings&) {}},
                    AxisWay{"cartesian",
                            [](WriterSettings& s) {
                              s.lattice = LatticeKind::cc, s.recommended_kernel = "default";
                            }},
                    AxisWay{"coarse",
                            [](WriterSettings& s) {
                              s.scales = {1.2, 1.1, 1.3, 1.4};
                            },
                            0.5},
                    AxisWay{"lowpass", [](WriterSettings& s) { s.lowpass = true; }},
                    AxisWay{"planesOutside", [](WriterSettings& s) { s.faces = Faces::predict; }},
                    AxisWay{"goesRoundInTime", [](WriterSettings& s) { s.ends = Ends::periodic; }},
                    AxisWay{"bounded", [](WriterSettings& s) { s.channels[0].abs_error = 0.02; }, 0.05}),
    [](const auto& way) { return way.param.name; });

TEST(PeriodicAxis, TheSeamIsAsGoodAsTheRest) {
  for (const LatticeKind kind : {LatticeKind::d4star, LatticeKind::cc}) {
    WriterSettings settings = round_settings();
    settings.lattice = kind;
    if (kind == LatticeKind::cc) settings.recommended_kernel = "default";
    std::vector<std::byte> bytes;
    write(settings, turned_clouds(0), bytes);
    Opened file(bytes);
    settings.turning = {};
    write(settings, turned_clouds(0), bytes);
    Opened mirrored(bytes);
    const double inside = axis_snr(file, 19, 23), first = axis_snr(file, 0, 2), last = axis_snr(file, -1, 0),
                 was = axis_snr(mirrored, 0, 2);
    EXPECT_GT(first, inside - 2);
    EXPECT_GT(last, inside - 2);
    EXPECT_LT(was, inside - 8);
    EXPECT_TRUE(std::isnan(axis_snr(mirrored, -1, 0))) << "outside";
  }
}

TEST(PeriodicAxis, TheEndIsTheBeginning) {
  std::vector<std::byte> bytes;
  write(round_settings(), turned_clouds(0), bytes);
  Opened file(bytes);
  std::vector<Vec4> begin, end;
  for (const Vec4& p : points_across(0, 1, 500))
    begin.push_back({0, p[1], p[2], p[3]}), end.push_back({axis_dims[0], p[1], p[2], p[3]});
  std::vector<float> x(begin.size()), y(end.size());
  std::vector<std::array<float, 4>> u(begin.size()), v(end.size());
  (void)evaluate4(*file.coefficients, begin, x, u, file.bench.context);
  (void)evaluate4(*file.coefficients, end, y, v, file.bench.context);
  for (size_t i = 0; i < x.size(); ++i) {
    ASSERT_NEAR(x[i], y[i], 2e-4);
    for (size_t a = 0; a < 4; ++a) ASSERT_NEAR(u[i][a], v[i][a], 1e-3);
  }
  const std::array<Vec4, 1> beyond{{{axis_dims[0] + 0.01, 9, 9, 2}}};
  EXPECT_TRUE(std::isnan(file.at(beyond)[0]));
}

// Slices of all kinds against the field of the volume, beside the seam.
TEST(PeriodicAxis, SlicesSeeNoSeam) {
  std::vector<std::byte> bytes;
  write(round_settings(), turned_clouds(0), bytes);
  Opened file(bytes);
  const Context context = file.bench.context;
  const std::array<Hyperplane, 7> planes{
      Hyperplane(0, 0, 0, 1, -2.3),         Hyperplane(1, 0, 0, 0, -47.6), Hyperplane(1, 0, 0, 0, -0.2),
      Hyperplane(0, 1, 0, 0, -9.3),         Hyperplane(0, 0, 1, 0, -8),    Hyperplane(0.3, 0.3, 0.2, 0.6, -8),
      Hyperplane(0.6, 0.1, 0.1, 0.3, -30.2)};
  for (const Hyperplane& h : planes) {
    const Slice slice = hyperslice(*file.coefficients, h, {}, {}, context);
    std::vector<Vec3> seen;
    std::vector<Vec4> points;
    for (int i = 0; i < 60000 && seen.size() < 1500; ++i) {
      Vec3 p;
      for (size_t k = 0; k < 3; ++k)
        p[k] = slice.domain_begin[k] + (slice.domain_end[k] - slice.domain_begin[k]) *
                                           std::fmod(0.5 + i * std::array{0.8192, 0.6710, 0.5497}[k], 1.0);
      const Vec3 uvw = slice.lattice_to_slice.point(p);
      Vec4 q = slice.origin;
      for (size_t k = 0; k < 3; ++k)
        for (size_t n = 0; n < 4; ++n) q[n] += uvw[k] * slice.basis[k][n];
      bool inside = (q[0] <= 1.5 || q[0] >= 46.5) && q[3] >= 1.5 && q[3] <= 3.5;
      for (size_t n = 0; n < 4; ++n) inside = inside && q[n] >= 0 && q[n] <= file.lattice().domain_end(n);
      for (size_t n = 1; n < 3; ++n) inside = inside && q[n] >= 3 && q[n] <= axis_dims[n] - 4.0;
      if (inside) seen.push_back(uvw), points.push_back(q);
    }
    ASSERT_GT(seen.size(), 20u);
    std::vector<float> got(seen.size());
    EXPECT_EQ(sample_points(slice, seen, got, {}, context).outside, 0u);
    const auto expected = file.at(points);
    for (size_t i = 0; i < got.size(); ++i) ASSERT_NEAR(got[i], expected[i], 1.5) << i;
    if (!slice.is_time_slice()) continue;
    for (size_t i = 0; i < got.size(); i += 50)
      ASSERT_NEAR(got[i], evaluate_reference(slice, slice.lattice_to_slice.inverse().point(seen[i]), nullptr),
                  1e-3);
  }
  EXPECT_THROW((void)Extraction(file.samples, 0, planes[5], plane_axes(planes[5]), context), Error);
}

// Cutting a slice to a box reads what is at the other end; coarser slices and the points of pictures go
// round.
TEST(PeriodicAxis, BoxesCoarserSlicesAndPointsGoRound) {
  std::vector<std::byte> bytes;
  write(round_settings(), turned_clouds(0), bytes);
  Opened file(bytes);
  const Context context = file.bench.context;
  const Hyperplane now(0, 0, 0, 1, -2.3);
  const Slice whole = hyperslice(*file.coefficients, now, {}, {}, context);
  for (const double from : {0.0, 40.0}) {
    HypersliceOptions options;
    options.box = IndexBox{{from, 2, 2}, {from + 8, 12, 12}};
    const BrickBox region = options.reads(file.lattice(), file.coefficients->kernel());
    const Coefficients some(file.samples, 0, file.coefficients->kernel(), 0, 64 << 20, region);
    const Slice part = hyperslice(some, now, options, {}, context);
    for (double x = from; x <= from + 8; x += 0.37) {
      const std::array<Vec3, 1> p{{{x, 7.2, 6.1}}};
      std::array<float, 1> a, b;
      (void)sample_points(whole, p, a, {}, context);
      (void)sample_points(part, p, b, {}, context);
      ASSERT_EQ(a[0], b[0]) << x;
    }
  }
  const Slice coarse = coarsen(whole, context);
  EXPECT_TRUE(coarse.lattice.periodic[0]);
  for (const double x : {0.0, 0.6, 47.2, 48.0}) {
    const std::array<Vec3, 1> p{{{x, 9.2, 8.1}}};
    std::array<float, 1> a, b;
    (void)sample_points(whole, p, a, {}, context);
    (void)sample_points(coarse, p, b, {}, context);
    EXPECT_NEAR(a[0], b[0], 12) << x;
  }
  // What stands beyond one end of the drawn box stands at the other.
  const SplatPoints points = make_points(whole, context);
  const auto sum_near = [&](double x) {
    double sum = 0;
    for (const SplatBrick& b : points.bricks)
      for (uint32_t n = b.first; n < b.first + b.count; ++n) {
        const Vec3 at = points.at(b, n);
        const Vec3 d = at - Vec3{x, whole.domain_end[1] / 2, whole.domain_end[2] / 2};
        const double r2 = dot(d, d);
        if (r2 < whole.kernel.space.radius * whole.kernel.space.radius)
          sum += points.coefficient[n] * whole.kernel.space.value(r2);
      }
    return sum;
  };
  EXPECT_GT(std::fabs(sum_near(0)), 1);
  EXPECT_NEAR(sum_near(0), sum_near(whole.domain_end[0]), 1e-3);
}

TEST(PeriodicAxis, BoundsHoldAtTheSeam) {
  WriterSettings settings = round_settings();
  settings.channels[0].abs_error = 0.02, settings.scales = {1.4, 1.4, 1.4, 1.2};
  const Series s = turned_clouds(0);
  std::vector<std::byte> bytes;
  write(settings, s, bytes);
  Opened file(bytes);
  ASSERT_TRUE(file.corrections);
  const Slice slice = time_slice(*file.coefficients, 2, {0, 0}, {}, file.bench.context);
  for (uint32_t z = 0; z < axis_dims[2]; ++z)
    for (uint32_t y = 0; y < axis_dims[1]; ++y)
      for (const uint32_t x : {0u, 1u, 46u, 47u, 48u}) {
        const std::array<Vec4, 1> p{{{1.0 * x, 1.0 * y, 1.0 * z, 2}}};
        const double truth = s.frame(2)[(size_t{z} * axis_dims[1] + y) * axis_dims[0] + x % axis_dims[0]];
        ASSERT_NEAR(file.at(p)[0], truth, 0.0201) << x << " " << y << " " << z;
        const std::array<Vec3, 1> q{{{1.0 * x, 1.0 * y, 1.0 * z}}};
        std::array<float, 1> got;
        (void)sample_points(slice, q, got, {}, file.bench.context);
        ASSERT_NEAR(got[0], truth, 0.0201) << x << " " << y << " " << z;
      }
}

// Land on either side of the seam: which side a point belongs to, and what it looks like beside it.
TEST(PeriodicAxis, MasksGoRound) {
  const float none = std::numeric_limits<float>::quiet_NaN();
  WriterSettings settings = round_settings();
  settings.nonfinite = NonFinite::hole;
  const auto with_gap = [&](int64_t first, int64_t last, double shift) {
    Series s = turned_clouds(shift);
    for (size_t i = 0; i < s.values.size(); ++i) {
      const int64_t x = i % axis_dims[0];
      const bool land = first <= last ? x >= first && x <= last : x >= first || x <= last;
      if (land && i / axis_dims[0] % axis_dims[1] > 9) s.values[i] = none;
    }
    return s;
  };
  std::vector<std::byte> bytes;
  write(settings, with_gap(45, 2, 0), bytes);
  Opened a(bytes);
  write(settings, with_gap(21, 26, half), bytes);
  Opened b(bytes);
  expect_sound(a);
  const Slice slice = time_slice(*a.coefficients, 2, {0, 0}, {}, a.bench.context);
  ASSERT_TRUE(slice.mask);
  for (double x = 42; x < 54; x += 0.17)
    for (const double y : {6.0, 8.9, 12.0}) {
      const double at = std::fmod(x, 48.0);
      const std::array<Vec4, 1> p{{{at, y, 8.3, 2}}}, q{{{x - half, y, 8.3, 2}}};
      const float got = a.at(p)[0], other = b.at(q)[0];
      ASSERT_EQ(std::isnan(got), std::isnan(other)) << x;
      EXPECT_EQ(slice.mask->missing({at, y, 8.3}), std::isnan(got)) << x;
      if (!std::isnan(got)) {
        EXPECT_NEAR(got, other, 1) << x << " " << y; // land is filled in a little differently
      }
    }
  const std::array<Vec4, 3> ends{{{47.6, 12, 9, 2}, {48, 12, 9, 2}, {44.4, 12, 9, 2}}};
  const auto got = a.at(ends);
  EXPECT_TRUE(std::isnan(got[0]) && std::isnan(got[1]));
  EXPECT_FALSE(std::isnan(got[2]));
}

TEST(PeriodicAxis, LevelsFieldsAndSingleFramesGoRound) {
  WriterSettings settings = round_settings();
  settings.levels = 1;
  std::vector<std::byte> bytes;
  write(settings, turned_clouds(0), bytes);
  {
    Opened coarse(bytes, 1);
    EXPECT_TRUE(coarse.lattice().turns(0));
    EXPECT_EQ(coarse.lattice().domain_end(0), axis_dims[0]);
    EXPECT_GT(axis_snr(coarse, -1, 1), axis_snr(coarse, 20, 22) - 3);
  }
  settings = round_settings();
  for (const uint32_t frames : {1u, 6u}) {
    settings.dims[3] = frames;
    Bench bench(2);
    VolumeWriter writer(settings, create_memory_sink(bytes), bench.context);
    writer.add_field(0, [](std::span<const double> points, std::span<float> values) {
      for (size_t i = 0; i < values.size(); ++i)
        values[i] = static_cast<float>(
            clouds(points[4 * i], points[4 * i + 1], points[4 * i + 2], points[4 * i + 3]));
      return true;
    });
    (void)writer.finish();
    Opened file(bytes);
    expect_sound(file);
    if (frames > 1) {
      EXPECT_GT(axis_snr(file, -1, 1), axis_snr(file, 20, 22) - 2);
    }
    const std::array<Vec4, 2> ends{{{0, 9, 8, 0}, {axis_dims[0], 9, 8, 0}}};
    const auto got = file.at(ends);
    EXPECT_NEAR(got[0], got[1], 2e-4);
    EXPECT_NEAR(got[0], clouds(0, 9, 8, 0), 1.5);
  }
}

// Short axes turn several times within the reach of filters and kernels.
TEST(PeriodicAxis, MayBeShortAndManifold) {
  for (const LatticeKind kind : {LatticeKind::d4star, LatticeKind::cc})
    for (const uint32_t n : {2u, 3u, 5u, 16u}) {
      SCOPED_TRACE(n);
      const double per = 2 * std::numbers::pi / n;
      const auto value = [&](double x, double y, double z, double t) {
        return 40 + 8 * std::sin(per * y + 0.3) * std::cos(0.2 * x) + 5 * std::sin(per * z + 0.1 * t);
      };
      const Series s({20, n, n, 5}, value);
      WriterSettings settings = round_settings();
      settings.dims = s.dims, settings.turning = {false, true, true}, settings.lattice = kind;
      if (kind == LatticeKind::cc) settings.recommended_kernel = "default";
      std::vector<std::byte> bytes;
      write(settings, s, bytes);
      Opened file(bytes);
      expect_sound(file);
      if (n == 2) continue; // the Nyquist frequency, of which no lattice keeps the phase
      for (int i = 0; i < 200; ++i) {
        const Vec4 p{4 + 0.05 * i, std::fmod(0.61 * i, n), std::fmod(0.37 * i, n), 2};
        ASSERT_NEAR(file.at({&p, 1})[0], value(p[0], p[1], p[2], p[3]), 2.5) << i;
      }
    }
}

TEST(PeriodicAxis, WhatCannotBeIsRefused) {
  const auto code = [](const std::function<void(WriterSettings&)>& change) {
    WriterSettings settings = round_settings();
    change(settings);
    Bench bench;
    std::vector<std::byte> bytes;
    try {
      const VolumeWriter writer(settings, create_memory_sink(bytes), bench.context);
    } catch (const Error& e) {
      return e.code();
    }
    return Code::ok;
  };
  EXPECT_EQ(code([](WriterSettings&) {}), Code::ok);
  EXPECT_EQ(code([](WriterSettings& s) { s.dims[0] = 1; }), Code::invalid_argument);
  EXPECT_EQ(code([](WriterSettings& s) {
              s.faces = Faces::along, s.faces_along = {true, false, false};
            }),
            Code::invalid_argument);
  EXPECT_EQ(code([](WriterSettings& s) {
              s.faces = Faces::along, s.faces_along = {false, true, false};
            }),
            Code::ok);
}

} // namespace
} // namespace bccsplat
