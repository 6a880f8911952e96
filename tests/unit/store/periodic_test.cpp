// SPDX-License-Identifier: Apache-2.0
// Series whose last frame leads to the first. Nothing tells such a file where it begins: one that begins some
// frames later, a whole number of layers, is the same turned round, whatever looks at it. And it is as good
// at its ends as elsewhere.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>

#include <unistd.h>

#include "field/sample_grid.h"
#include "slice/extraction.h"
#include "slice/hyperslice.h"
#include "slice/time_slice.h"
#include "tests/unit/store/written_series.h"

namespace bccsplat {
namespace {

using test::Bench;
using test::expect_sound;
using test::Opened;
using test::Series;
using test::write;

constexpr std::array<uint32_t, 4> dims{26, 24, 20, 16};
// D4* takes a turn of 16 frames in 24 layers: 8 frames are 12 of them, of coset 0 again.
constexpr int32_t half_frames = 8;

// A blob that goes round once in `turn` frames, never the same seen backwards.
double blob(double x, double y, double z, double t, double turn = dims[3]) {
  const double at = 2 * std::numbers::pi * t / turn;
  const double dx = x - 12.5 - 5 * std::cos(at), dy = y - 11.5 - 4 * std::sin(at),
               dz = z - 9.5 - 1.5 * std::sin(at + 1);
  return 100 * std::exp(-(dx * dx + dy * dy + dz * dz) / 24);
}

Series turned_blob(double shift) {
  return Series(dims, [&](double x, double y, double z, double t) { return blob(x, y, z, t + shift); });
}

WriterSettings periodic_settings() {
  WriterSettings s;
  s.dims = dims, s.ends = Ends::periodic, s.faces = Faces::mirror;
  return s;
}

// Points at moments of [begin, end), about `count` of them near where the blob goes.
std::vector<Vec4> points_in(double begin, double end, int count) {
  std::vector<Vec4> points;
  for (int i = 0; i < count; ++i) {
    const auto part = [&](double step, double low, double high) {
      return low + (high - low) * std::fmod(0.5 + i * step, 1.0);
    };
    points.push_back(
        {part(0.8567, 5, 20), part(0.7338, 5, 18), part(0.6288, 5, 14), part(0.5386, begin, end)});
  }
  return points;
}

double turned_time(double t, double by) { return std::fmod(t + by + dims[3], static_cast<double>(dims[3])); }

// Whether `b` is `a` seen half a turn later, sample by sample and between them.
void expect_turned(Opened& a, Opened& b, double tolerance) {
  const int32_t layers = a.lattice().layers();
  ASSERT_EQ(a.lattice(), b.lattice());
  const int32_t by = static_cast<int32_t>(std::lround(half_frames / a.lattice().time_step));
  ASSERT_NEAR(by * a.lattice().time_step, half_frames, 1e-9);
  for (int32_t m = 0; m < layers; ++m) {
    const auto late = layer_to_dense(a.samples.read_layer(0, (m + by) % layers, {}, a.bench.context)),
               early = layer_to_dense(b.samples.read_layer(0, m, {}, b.bench.context));
    EXPECT_EQ(late, early) << m;
  }
  const std::vector<Vec4> points = points_in(0, dims[3], 4000);
  std::vector<Vec4> turned = points;
  for (Vec4& p : turned) p[3] = turned_time(p[3], -half_frames);
  const auto x = a.at(points), y = b.at(turned);
  for (size_t i = 0; i < points.size(); ++i) {
    ASSERT_EQ(std::isnan(x[i]), std::isnan(y[i])) << points[i][3];
    if (std::isnan(x[i])) continue;
    ASSERT_NEAR(x[i], y[i], tolerance) << points[i][3];
  }
}

TEST(PeriodicLattice, AWholeNumberOfLayersIsATurn) {
  for (const LatticeKind kind : {LatticeKind::d4star, LatticeKind::cc})
    for (const uint32_t frames : {2u, 3u, 7u, 20u, 365u})
      for (const double scale : {0.4, 1.0, 2.7}) {
        const Lattice4 l = Lattice4::fit(kind, {9, 9, 9, frames}, {1, 1, 1, scale}, 0, {}, true);
        EXPECT_NEAR(l.layers() * l.time_step, frames, 1e-12 * frames);
        EXPECT_EQ(l.layers() % l.layer_period(), 0);
        EXPECT_LE(l.scales()[3], std::max(scale, frames / 2.0 / l.space.plane_distance()) + 1e-9);
        EXPECT_EQ(l.mirror_layer(-1), l.last_layer);
        EXPECT_EQ(l.mirror_layer(l.layers()), 0);
        EXPECT_EQ(l.mirror_layer(-2 * l.layers() - 1), l.last_layer);
        EXPECT_EQ(l.last_frame(), frames);
        EXPECT_EQ(l.nearest_frame(frames - 0.4), 0);
        EXPECT_EQ(l.nearest_frame(-0.6), frames - 1);
      }
}

struct Way {
  const char* name;
  std::function<void(WriterSettings&)> set;
  double tolerance = 2e-3;
};

class Periodic : public testing::TestWithParam<Way> {};

TEST_P(Periodic, HasNoBeginning) {
  WriterSettings settings = periodic_settings();
  GetParam().set(settings);
  std::vector<std::byte> bytes;
  const WriteReport report = write(settings, turned_blob(0), bytes);
  EXPECT_EQ(report.frames, dims[3]);
  Opened a(bytes);
  write(settings, turned_blob(half_frames), bytes);
  Opened b(bytes);
  EXPECT_TRUE(a.lattice().periodic);
  expect_sound(a);
  expect_turned(a, b, GetParam().tolerance);
}

INSTANTIATE_TEST_SUITE_P(
    Ways, Periodic,
    testing::Values(Way{"samples", [](WriterSettings&) {}},
                    Way{"cartesian", [](WriterSettings& s) { s.lattice = LatticeKind::cc; }},
                    Way{"coarse",
                        [](WriterSettings& s) {
                          s.scales = {1.2, 1.1, 1.3, 1.6};
                        }},
                    Way{"lowpass", [](WriterSettings& s) { s.lowpass = true; }},
                    Way{"bounded",
                        [](WriterSettings& s) {
                          s.channels[0].abs_error = 0.02, s.scales = {1.5, 1.5, 1.5, 1};
                        },
                        0.05},
                    Way{"planesOutside", [](WriterSettings& s) { s.faces = Faces::predict; }},
                    Way{"levels", [](WriterSettings& s) { s.levels = 1; }}),
    [](const auto& way) { return way.param.name; });

// A few frames turn several times within the filter's reach, and all layers wait for the last one.
TEST(PeriodicSeries, MayBeShort) {
  for (const uint32_t frames : {2u, 3u, 5u})
    for (const bool lowpass : {false, true}) {
      SCOPED_TRACE(frames);
      const auto value = [&](double x, double y, double z, double t) {
        return 40 + 10 * std::sin(2 * std::numbers::pi * t / frames) * std::sin(0.2 * x + 0.1 * y) +
               5 * std::sin(0.25 * z);
      };
      const Series s({26, 24, 20, frames}, value);
      WriterSettings settings = periodic_settings();
      settings.dims = s.dims, settings.lowpass = lowpass, settings.measure = Measure::all;
      std::vector<std::byte> bytes;
      Bench bench(2);
      VolumeWriter writer(settings, create_memory_sink(bytes), bench.context);
      for (uint32_t t = 0; t < frames; ++t) {
        const FrameBox box = s.box(t);
        writer.add_frame(0, t, {&box, 1});
      }
      (void)writer.finish();
      Opened file(bytes);
      expect_sound(file);
      std::vector<Vec4> points = points_in(0, frames, 500);
      for (Vec4& p : points) p[3] = std::floor(p[3]);
      const auto got = file.at(points);
      // Two frames are the Nyquist frequency of a turn, of which no lattice keeps the phase.
      if (frames == 2) continue;
      for (size_t i = 0; i < points.size(); ++i)
        ASSERT_NEAR(got[i], value(points[i][0], points[i][1], points[i][2], points[i][3]), lowpass ? 5 : 2.5);
    }
}

// dB, over moments of [begin, end).
double snr(Opened& file, double begin, double end, double turn = dims[3]) {
  const std::vector<Vec4> points = points_in(begin, end, 6000);
  const auto got = file.at(points);
  double signal = 0, error = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    const Vec4& p = points[i];
    const double truth = blob(p[0], p[1], p[2], p[3], turn);
    signal += truth * truth, error += std::pow(got[i] - truth, 2);
  }
  return 10 * std::log10(signal / error);
}

TEST(PeriodicSeries, EndsAreAsGoodAsTheRest) {
  for (const LatticeKind kind : {LatticeKind::d4star, LatticeKind::cc}) {
    WriterSettings settings = periodic_settings();
    settings.lattice = kind, settings.channels[0].value_type = ValueType::f32;
    if (kind == LatticeKind::cc) settings.recommended_kernel = "default";
    std::vector<std::byte> bytes;
    write(settings, turned_blob(0), bytes);
    Opened periodic(bytes);
    const double inside = snr(periodic, 7, 9), behind = snr(periodic, 15, 16), first = snr(periodic, 0, 1);
    EXPECT_NEAR(behind, inside, 0.5);
    EXPECT_NEAR(first, inside, 0.5);
    settings.ends = Ends::mirror;
    write(settings, turned_blob(0), bytes);
    Opened mirrored(bytes);
    EXPECT_LT(snr(mirrored, 0, 1), inside - 15);
    EXPECT_TRUE(std::isnan(snr(mirrored, 15, 16))) << "outside";
  }
}

// What a writer measures is what a reader sees, whichever frame waited for the end.
TEST(PeriodicSeries, ErrorsAreMeasuredOfAllFrames) {
  WriterSettings settings = periodic_settings();
  settings.measure = Measure::all;
  const Series s = turned_blob(0);
  std::vector<std::byte> bytes;
  Bench bench(2);
  VolumeWriter writer(settings, create_memory_sink(bytes), bench.context);
  for (uint32_t t = 0; t < dims[3]; ++t) {
    const FrameBox box = s.box(t);
    writer.add_frame(0, t, {&box, 1});
  }
  (void)writer.finish();
  Opened file(bytes);
  for (uint32_t t = 0; t < dims[3]; ++t) {
    const MeasuredErrors measured = writer.measured(0, t);
    EXPECT_EQ(measured.frame, t);
    std::vector<Vec4> points;
    for (uint32_t z = 0; z < dims[2]; ++z)
      for (uint32_t y = 0; y < dims[1]; ++y)
        for (uint32_t x = 0; x < dims[0]; ++x) points.push_back({1.0 * x, 1.0 * y, 1.0 * z, 1.0 * t});
    const auto got = file.at(points);
    double squares = 0;
    for (size_t i = 0; i < points.size(); ++i)
      squares += std::pow(static_cast<double>(got[i]) - s.frame(t)[i], 2);
    EXPECT_NEAR(std::sqrt(squares / static_cast<double>(points.size())), measured.errors.all.rms(),
                2e-3 * measured.errors.all.rms() + 1e-5)
        << t;
  }
}

TEST(PeriodicSeries, SlicesSeeNoEnd) {
  WriterSettings settings = periodic_settings();
  settings.channels[0].value_type = ValueType::f32;
  std::vector<std::byte> bytes;
  write(settings, turned_blob(0), bytes);
  Opened a(bytes);
  write(settings, turned_blob(half_frames), bytes);
  Opened b(bytes);
  const Context context = a.bench.context;
  const auto values = [&](const Slice& slice, const std::vector<Vec3>& at) {
    std::vector<float> got(at.size());
    EXPECT_EQ(sample_points(slice, at, got, {}, context).outside, 0u);
    return got;
  };
  const auto expect_near = [](const std::vector<float>& x, const std::vector<float>& y, double tolerance) {
    for (size_t i = 0; i < x.size(); ++i) ASSERT_NEAR(x[i], y[i], tolerance) << i;
  };
  std::vector<Vec3> at;
  for (const Vec4& p : points_in(0, 1, 600)) at.push_back({p[0], p[1], p[2]});
  const auto time_plane = [](double t) { return Hyperplane(0, 0, 0, 1, -t); };
  for (const double t : {15.3, 15.99, 0.0, 0.4, 16.0}) {
    const double other = turned_time(t, -half_frames);
    expect_near(values(hyperslice(*a.coefficients, time_plane(t), {}, {}, context), at),
                values(hyperslice(*b.coefficients, time_plane(other), {}, {}, context), at), 1e-3);
    for (const ThicknessKind kind : {ThicknessKind::mean, ThicknessKind::maximum}) {
      HypersliceOptions thick;
      thick.thickness = {3, kind};
      expect_near(values(hyperslice(*a.coefficients, time_plane(t), thick, {}, context), at),
                  values(hyperslice(*b.coefficients, time_plane(other), thick, {}, context), at), 2e-3);
    }
  }
  EXPECT_THROW((void)hyperslice(*a.coefficients, time_plane(16.01), {}, {}, context), Error);
  // Planes of space, and oblique ones, against the field itself.
  const std::array<Hyperplane, 4> planes{Hyperplane(1, 0, 0, 0, -13.2), Hyperplane(0, 0, 1, 0, -9),
                                         Hyperplane(0.5, -0.3, 0.2, 0.4, -6),
                                         Hyperplane(0.1, 0.1, 0, 1, -17)};
  for (const Hyperplane& h : planes) {
    const Slice slice = hyperslice(*a.coefficients, h, {}, {}, context);
    std::vector<Vec3> seen;
    std::vector<Vec4> points;
    for (int i = 0; i < 4000; ++i) {
      Vec3 p;
      for (size_t k = 0; k < 3; ++k)
        p[k] = slice.domain_begin[k] + (slice.domain_end[k] - slice.domain_begin[k]) *
                                           std::fmod(0.5 + i * std::array{0.8192, 0.6710, 0.5497}[k], 1.0);
      const Vec3 uvw = slice.lattice_to_slice.point(p);
      Vec4 q = slice.origin;
      for (size_t k = 0; k < 3; ++k)
        for (size_t n = 0; n < 4; ++n) q[n] += uvw[k] * slice.basis[k][n];
      bool inside = q[3] <= 1 || q[3] >= 15;
      for (size_t n = 0; n < 4; ++n) inside = inside && q[n] >= 0 && q[n] <= a.lattice().domain_end(n);
      for (size_t n = 0; n < 3; ++n) inside = inside && q[n] >= 3 && q[n] <= dims[n] - 4.0;
      if (inside) seen.push_back(uvw), points.push_back(q);
    }
    ASSERT_GT(seen.size(), 50u);
    expect_near(values(slice, seen), a.at(points), 0.4);
  }
  const Extraction extraction(a.samples, 0, planes[3], plane_axes(planes[3]), context);
  const Extraction inner(b.samples, 0, Hyperplane(0.1, 0.1, 0, 1, -9), plane_axes(planes[3]), context);
  EXPECT_GT(extraction.list(0, nullptr, nullptr, context.progress), 0u);
}

TEST(PeriodicSeries, MasksAndBoundsGoRound) {
  const float none = std::numeric_limits<float>::quiet_NaN();
  WriterSettings settings = periodic_settings();
  settings.nonfinite = NonFinite::hole;
  const auto with_gap = [&](uint32_t frame) {
    Series s = turned_blob(frame == 0 ? 0 : half_frames);
    const size_t first = frame * s.frame_samples();
    for (size_t i = 0; i < s.frame_samples(); ++i)
      if (i % dims[0] > 14) s.values[first + i] = none;
    return s;
  };
  std::vector<std::byte> bytes;
  write(settings, with_gap(0), bytes);
  Opened a(bytes);
  write(settings, with_gap(half_frames), bytes);
  Opened b(bytes);
  expect_sound(a);
  expect_turned(a, b, 2e-3);
  const std::array<Vec4, 4> points{{{18, 9, 9, 15.6}, {18, 9, 9, 15.4}, {18, 9, 9, 0.4}, {9, 9, 9, 15.6}}};
  const auto got = a.at(points);
  EXPECT_TRUE(std::isnan(got[0])) << "nearer to frame 0";
  EXPECT_FALSE(std::isnan(got[1]));
  EXPECT_TRUE(std::isnan(got[2]));
  EXPECT_FALSE(std::isnan(got[3]));
  const Slice late = time_slice(*a.coefficients, 15.6, {0, 0}, {}, a.bench.context);
  ASSERT_TRUE(late.mask);
  EXPECT_TRUE(late.mask->missing({18, 9, 9}));
  EXPECT_FALSE(time_slice(*a.coefficients, 15.4, {0, 0}, {}, a.bench.context).mask);
}

TEST(PeriodicSeries, LayersAndFieldsGoRound) {
  WriterSettings settings = periodic_settings();
  settings.channels[0].value_type = ValueType::f32;
  std::vector<std::byte> bytes;
  Bench bench(2);
  VolumeWriter writer(settings, create_memory_sink(bytes), bench.context);
  writer.add_field(0, [](std::span<const double> points, std::span<float> values) {
    for (size_t i = 0; i < values.size(); ++i)
      values[i] =
          static_cast<float>(blob(points[4 * i], points[4 * i + 1], points[4 * i + 2], points[4 * i + 3]));
    return true;
  });
  (void)writer.finish();
  Opened file(bytes);
  expect_sound(file);
  const double inside = snr(file, 7, 9);
  EXPECT_NEAR(snr(file, 15, 16), inside, 0.5);
  EXPECT_NEAR(snr(file, 0, 1), inside, 0.5);
}

// A journal tells of slabs in the order in which they are written.
TEST(PeriodicSeries, MayBeResumed) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("bccsplat-resumed-" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  // Enough bytes that the journal tells of some before the end.
  const Series s = test::noise(dims, 3);
  const auto noisy_settings = [] {
    WriterSettings settings = periodic_settings();
    settings.scales = {0.7, 0.7, 0.7, 1}, settings.channels[0].value_type = ValueType::f32;
    return settings;
  };
  const auto make = [&](Continuity continuity, uint32_t frames) {
    WriterSettings settings = noisy_settings();
    settings.path = (folder / "p.bcc4").string(), settings.continuity = continuity;
    Bench bench(2);
    VolumeWriter writer(settings, nullptr, bench.context);
    for (uint32_t t = 0; t < frames; ++t) {
      const FrameBox box = s.box(t);
      writer.add_frame(0, t, {&box, 1});
    }
    return frames < dims[3] ? 0 : writer.finish().slabs_reused;
  };
  make(Continuity::journal, dims[3] - 1);
  EXPECT_GT(make(Continuity::resume, dims[3]), 0u);
  std::vector<std::byte> bytes;
  write(noisy_settings(), s, bytes);
  Opened whole(bytes);
  { // closed before it is removed
    const auto resumed = Bcc4Reader::open(open_file_source((folder / "p.bcc4").string()));
    EXPECT_EQ(resumed->bytes().file, whole.reader->bytes().file);
    const Bcc4Samples samples(resumed, whole.bench.memory, 64 << 20, RelativeTo::base);
    for (int32_t m = 0; m < whole.lattice().layers(); ++m)
      EXPECT_EQ(layer_to_dense(samples.read_layer(0, m, {}, whole.bench.context)),
                layer_to_dense(whole.samples.read_layer(0, m, {}, whole.bench.context)));
  }
  std::filesystem::remove_all(folder);
}

TEST(PeriodicSeries, WhatCannotBeIsRefused) {
  const auto code = [](const std::function<void(WriterSettings&)>& change) {
    WriterSettings settings = periodic_settings();
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
  EXPECT_EQ(code([](WriterSettings& s) { s.dims[3] = 0; }), Code::invalid_argument);
  EXPECT_EQ(code([](WriterSettings& s) { s.dims[3] = 1; }), Code::invalid_argument);
  EXPECT_EQ(code([](WriterSettings& s) {
              s.part = PartSettings{SeriesBlock::of_frames(0, 4), 0, {}};
              for (uint32_t t = 0; t < dims[3]; ++t) s.part->times.push_back(t);
            }),
            Code::unsupported);
}

} // namespace
} // namespace bccsplat
