// SPDX-License-Identifier: Apache-2.0
// Fields about a large constant whose air is somewhere else: a host's pressure, 101325 Pa with air 0. A
// kernel's sum ripples about 1 by 0.0024 (default), which of the distance from air would be 240 Pa.
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <thread>

#include "fit_writer.h"

namespace bccsplat::test {
namespace {

constexpr double pressure = 101325.25;

double wave(double x, double y, double z, double t) {
  return std::sin(0.31 * x + 0.22 * y - 0.27 * z + 0.24 * t);
}
std::array<double, 4> slope(const std::array<double, 4>& p) {
  const double c = std::cos(0.31 * p[0] + 0.22 * p[1] - 0.27 * p[2] + 0.24 * p[3]);
  return {0.31 * c, 0.22 * c, -0.27 * c, 0.24 * c};
}

// constant + signal * wave
Source around(double constant, double signal, int32_t type = BCCSPLAT_TYPE_F32) {
  return source_of({22, 21, 20, 24}, type, [&](double x, double y, double z, double t) {
    return constant + signal * wave(x, y, z, t);
  });
}

Bytes stored(const TestDevice& device, const Source& s,
             const bccsplat_writer_options& options = sized<bccsplat_writer_options>(),
             const bccsplat_channel_options& channel = sized<bccsplat_channel_options>()) {
  Written w = write_frames(device, s, options, channel);
  EXPECT_EQ(w.status, BCCSPLAT_OK) << w.text;
  return std::move(w.bytes);
}

struct ConstantErrors {
  double rms = 0, gradient_db = 0; // of values; signal to error of the four slopes
};

// At random points 5 samples and more from faces and ends.
ConstantErrors errors_of(const OpenVolume& volume, double constant, double signal) {
  std::mt19937 random(7);
  std::vector<std::array<double, 4>> points(2000);
  constexpr std::array<double, 4> last{21, 20, 19, 23};
  for (auto& p : points)
    for (size_t a = 0; a < 4; ++a) p[a] = std::uniform_real_distribution<double>(5, last[a] - 5)(random);
  std::vector<float> values(points.size()), gradients(4 * points.size());
  EXPECT_EQ(bccsplat_volume_evaluate(volume.volume, points.size(), points.data()->data(), values.data(),
                                     gradients.data()),
            BCCSPLAT_OK);
  double squares = 0, steep = 0, off = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    const auto& p = points[i];
    squares += std::pow(double(values[i]) - constant - signal * wave(p[0], p[1], p[2], p[3]), 2);
    const std::array<double, 4> g = slope(p);
    for (size_t a = 0; a < 4; ++a) {
      steep += std::pow(signal * g[a], 2);
      off += std::pow(double(gradients[4 * i + a]) - signal * g[a], 2);
    }
  }
  constexpr double infinite = std::numeric_limits<double>::infinity();
  return {std::sqrt(squares / double(points.size())), off > 0 ? 10 * std::log10(steep / off) : infinite};
}

// Infinity where less than a sixth of the values are numbers: outside of an oblique slice they are not.
double largest_difference(const std::vector<float>& values, double from) {
  double most = 0;
  size_t compared = 0;
  for (const float v : values)
    if (!std::isnan(v)) ++compared, most = std::max(most, std::fabs(double(v) - from));
  return 6 * compared < values.size() || compared == 0 ? INFINITY : most;
}

// The pixels of one channel of a picture, red alone where there are four floats.
std::vector<float> picture(const TestDevice& device, const Cut& cut, int32_t mode, uint32_t channel) {
  constexpr uint32_t size = 40;
  bccsplat_renderer* renderer = nullptr;
  EXPECT_EQ(bccsplat_renderer_create(device.device, &renderer), BCCSPLAT_OK);
  EXPECT_EQ(bccsplat_renderer_set_slice(renderer, cut.slice), BCCSPLAT_OK);
  auto options = sized<bccsplat_render_options>();
  options.mode = mode;
  EXPECT_EQ(bccsplat_renderer_set_options(renderer, &options), BCCSPLAT_OK);
  bccsplat_frame* frame = nullptr;
  EXPECT_EQ(
      bccsplat_frame_create(device.device, size, size, BCCSPLAT_FRAME_RGBA | BCCSPLAT_FRAME_VALUE, &frame),
      BCCSPLAT_OK);
  EXPECT_EQ(bccsplat_renderer_render(renderer, frame), BCCSPLAT_OK) << bccsplat_last_error();
  auto plane = sized<bccsplat_plane>();
  EXPECT_EQ(bccsplat_frame_get_channel(frame, channel, &plane), BCCSPLAT_OK);
  std::vector<float> pixels;
  const uint32_t floats = channel == BCCSPLAT_FRAME_RGBA ? 4 : 1;
  for (uint32_t y = 0; y < size; ++y)
    for (uint32_t x = 0; x < size; ++x)
      pixels.push_back(plane.pixels[y * (plane.row_bytes / sizeof(float)) + floats * x]);
  bccsplat_frame_release(frame);
  bccsplat_renderer_release(renderer);
  return pixels;
}

constexpr std::array<double, 5> in_time{0, 0, 0, 1, -11.3}, across_x{1, 0, 0, 0, -10.4},
    oblique{1, 0.5, 0, 0.7, -22};

TEST(Constants, ComeBackFarFromAir) {
  const TestDevice device;
  const Bytes bytes = stored(device, around(pressure, 0));
  const OpenVolume volume(device, bytes);
  const double tolerance = 1e-5 * pressure;
  std::vector<std::array<double, 4>> points;
  for (int i = 0; i < 500; ++i) points.push_back({0.042 * i, 0.04 * i, 19 - 0.038 * i, 0.046 * i});
  std::vector<float> gradients(4 * points.size()), values(points.size());
  ASSERT_EQ(bccsplat_volume_evaluate(volume.volume, points.size(), points.data()->data(), values.data(),
                                     gradients.data()),
            BCCSPLAT_OK);
  EXPECT_LT(largest_difference(values, pressure), tolerance);
  EXPECT_LT(largest_difference(gradients, 0), tolerance);
  for (const auto& h : {in_time, across_x, oblique}) {
    const Cut cut(volume, h);
    EXPECT_LT(largest_difference(cut.samples(), pressure), tolerance);
    EXPECT_EQ(cut.info.air, 0);
    EXPECT_NEAR(cut.info.bounds[0], pressure, tolerance);
    EXPECT_NEAR(cut.info.bounds[1], pressure, tolerance);
  }
  auto slab = sized<bccsplat_slice_options>();
  slab.thickness = 3;
  for (const int32_t kind : {BCCSPLAT_SLAB_MEAN, BCCSPLAT_SLAB_SUM, BCCSPLAT_SLAB_MAXIMUM}) {
    slab.slab = kind;
    const double held = kind == BCCSPLAT_SLAB_SUM ? 3 * pressure : pressure;
    for (const auto& h : {in_time, across_x})
      EXPECT_LT(largest_difference(Cut(volume, h, slab).samples(), held), 1e-5 * held) << kind;
  }
  slab.slab = BCCSPLAT_SLAB_MEAN;
  EXPECT_LT(largest_difference(Cut(volume, oblique, slab).samples(), pressure), tolerance);
}

// Pictures of slices whose coefficients are all 0 show the constant all the same.
TEST(Constants, PicturesShowThemFarFromAir) {
  const TestDevice device;
  Source near = around(pressure, 0);
  near.air = 1e5;
  const Bytes far_bytes = stored(device, around(pressure, 0)), near_bytes = stored(device, near);
  const OpenVolume far(device, far_bytes), nearer(device, near_bytes);
  for (const auto& h : {in_time, across_x, oblique}) {
    const Cut cut(far, h), from_air(nearer, h);
    for (const int32_t mode : {BCCSPLAT_MODE_COMPOSITE, BCCSPLAT_MODE_MAXIMUM}) {
      const std::vector<float> values = picture(device, cut, mode, BCCSPLAT_FRAME_VALUE);
      EXPECT_LT(largest_difference(values, pressure), 1e-5 * pressure) << mode;
      EXPECT_GT(std::count_if(values.begin(), values.end(), [](float v) { return !std::isnan(v); }), 300);
    }
    // Integrals are those of the distance from air.
    const auto all = picture(device, cut, BCCSPLAT_MODE_XRAY, BCCSPLAT_FRAME_RGBA),
               above = picture(device, from_air, BCCSPLAT_MODE_XRAY, BCCSPLAT_FRAME_RGBA);
    EXPECT_GT(*std::max_element(all.begin(), all.end()), 5 * pressure);
    for (size_t i = 0; i < all.size(); ++i)
      ASSERT_NEAR(double(all[i]) / pressure, double(above[i]) / (pressure - 1e5), 1e-3) << i;
  }
}

// Whoever adds up points has them all, relative to air.
TEST(Constants, PointsAreRelativeToAir) {
  const TestDevice device;
  const Bytes bytes = stored(device, around(pressure, 0));
  const OpenVolume volume(device, bytes);
  const Cut cut(volume, in_time);
  uint64_t count = 0;
  ASSERT_EQ(bccsplat_slice_get_points(cut.slice, 0, nullptr, nullptr, &count), BCCSPLAT_OK);
  EXPECT_EQ(count, cut.info.points);
  EXPECT_GT(count, 20u * 19 * 18 / 2); // a BCC lattice in lattice units of about a sample
  std::vector<float> coefficients(count), positions(3 * count);
  ASSERT_EQ(bccsplat_slice_get_points(cut.slice, count, positions.data(), coefficients.data(), nullptr),
            BCCSPLAT_OK);
  EXPECT_LT(largest_difference(coefficients, pressure), 1e-5 * pressure);
}

// The errors of slices on their own grid, away from faces and ends.
double slice_rms(const OpenVolume& volume, const std::array<double, 5>& h, double constant, double signal) {
  const Cut cut(volume, h);
  double squares = 0, n = 0;
  const std::vector<float> values = cut.samples();
  for (size_t i = 0; i < values.size(); ++i) {
    const auto p = cut.place(i);
    const bool inside =
        p[0] > 5 && p[0] < 16 && p[1] > 5 && p[1] < 15 && p[2] > 5 && p[2] < 14 && p[3] > 5 && p[3] < 18;
    if (!inside || std::isnan(values[i])) continue;
    squares += std::pow(double(values[i]) - constant - signal * wave(p[0], p[1], p[2], p[3]), 2), ++n;
  }
  EXPECT_GT(n, 0);
  return std::sqrt(squares / n);
}

// As good as with an air among the values, whatever the type.
TEST(Constants, WavesAroundThemFarFromAir) {
  const TestDevice device;
  const auto check = [&](double constant, double air, int32_t type, const bccsplat_writer_options& options,
                         double least_db, const char* what) {
    Source s = around(constant, 50, type);
    s.air = air;
    const Bytes far_bytes = stored(device, s, options);
    s.air = constant;
    const Bytes near_bytes = stored(device, s, options);
    const OpenVolume far(device, far_bytes), near(device, near_bytes);
    const ConstantErrors e = errors_of(far, constant, 50), best = errors_of(near, constant, 50);
    EXPECT_LT(e.rms, 1.1 * best.rms + 0.01) << what;
    EXPECT_GT(e.gradient_db, std::max(least_db, best.gradient_db - 1)) << what;
    for (const auto& h : {in_time, across_x, oblique})
      EXPECT_LT(slice_rms(far, h, constant, 50), 1.1 * slice_rms(near, h, constant, 50) + 0.01) << what;
  };
  const auto options = sized<bccsplat_writer_options>();
  check(pressure, 0, BCCSPLAT_TYPE_F32, options, 30, "f32");
  check(pressure, 2e5, BCCSPLAT_TYPE_F32, options, 30, "air above the values");
  check(40000, 0, BCCSPLAT_TYPE_U16, options, 25, "u16, whose steps are the rest of the error");
  check(pressure, 0, BCCSPLAT_TYPE_I32, options, 28, "i32");
  auto lattice = options;
  lattice.lattice = BCCSPLAT_LATTICE_CC;
  check(pressure, 0, BCCSPLAT_TYPE_F32, lattice, 20, "Cartesian");
}

// Integers of 32 bits are stored as floats relative to air and come back as floats: beside 2e9 these have
// steps of 128, so that values keep nothing of a signal of 100, and gradients what the file has.
TEST(Constants, RoundingIsWhatIsLostOfTwoThousandMillions) {
  const TestDevice device;
  constexpr double constant = 2e9;
  for (const int32_t type : {BCCSPLAT_TYPE_I32, BCCSPLAT_TYPE_F64, BCCSPLAT_TYPE_F32}) {
    Source s = around(constant, 100, type);
    const Bytes zero_bytes = stored(device, s);
    const ConstantErrors far = errors_of(OpenVolume(device, zero_bytes), constant, 100);
    EXPECT_LT(far.rms, 100) << type;         // of 4.8e6 by the ripple
    if (type == BCCSPLAT_TYPE_F32) continue; // the source has such steps itself
    s.air = constant;
    const Bytes near_bytes = stored(device, s);
    const ConstantErrors near = errors_of(OpenVolume(device, near_bytes), constant, 100);
    EXPECT_LT(near.rms, 128 / std::sqrt(12.0) + 5) << type;
    EXPECT_GT(near.gradient_db, 30) << type;
  }
}

// What is not stored is air, exactly, however far from it the rest is.
TEST(Constants, SparseDataKeepAir) {
  const TestDevice device;
  Source s = around(pressure, 50);
  for (size_t i = 0; i < s.values.size(); ++i)
    if (i % 22 < 11) s.values[i] = 0;
  const Bytes bytes = stored(device, s);
  const OpenVolume volume(device, bytes);
  EXPECT_EQ(volume.at({{1, 10, 10, 12}})[0], 0);
  EXPECT_NEAR(double(volume.at({{18, 10, 10, 12}})[0]), pressure, 300); // rippling, as it always did
  const Cut cut(volume, in_time);
  uint64_t count = 0;
  ASSERT_EQ(bccsplat_slice_get_points(cut.slice, 0, nullptr, nullptr, &count), BCCSPLAT_OK);
  EXPECT_EQ(count, cut.info.points);
  EXPECT_LT(count, Cut(OpenVolume(device, stored(device, around(pressure, 50))), in_time).info.points);
}

// Missing data of frames, which a mask tells, change nothing about the rest.
TEST(Constants, MissingDataLeaveTheOthersAlone) {
  const TestDevice device;
  Source s = around(pressure, 50);
  for (size_t i = 0; i < s.values.size(); ++i) {
    const size_t x = i % 22, y = i / 22 % 21, z = i / (22 * 21) % 20;
    if (x >= 18 && y >= 17 && z >= 16) s.values[i] = std::numeric_limits<double>::quiet_NaN();
  }
  auto options = sized<bccsplat_writer_options>();
  options.nonfinite = BCCSPLAT_NONFINITE_HOLE;
  const Bytes bytes = stored(device, s, options);
  const OpenVolume volume(device, bytes);
  EXPECT_TRUE(std::isnan(volume.at({{20, 19, 18, 12}})[0]));
  const ConstantErrors e = errors_of(volume, pressure, 50);
  EXPECT_LT(e.rms, 0.2);
  EXPECT_GT(e.gradient_db, 30);
}

// Nor do so many that sites deep among them are not even stored.
TEST(Constants, MissingDataThatAreLeftOutLeaveTheOthersAlone) {
  const TestDevice device;
  Source s = source_of({48, 20, 20, 10}, BCCSPLAT_TYPE_F32, [](double x, double y, double z, double t) {
    return x < 20 ? pressure + 50 * wave(x, y, z, t) : std::numeric_limits<double>::quiet_NaN();
  });
  auto options = sized<bccsplat_writer_options>();
  options.nonfinite = BCCSPLAT_NONFINITE_HOLE;
  const Written w = write_frames(device, s, options);
  ASSERT_EQ(w.status, BCCSPLAT_OK) << w.text;
  EXPECT_LT(w.report.sites_kept, w.report.sites_total * 4 / 5);
  const OpenVolume volume(device, w.bytes);
  EXPECT_TRUE(std::isnan(volume.at({{45, 10, 10, 5}})[0]));
  for (double x = 5; x < 14; x += 0.17) {
    const double at = x * 0.6 + 3;
    EXPECT_NEAR(double(volume.at({{x, at, 9, 5.2}})[0]), pressure + 50 * wave(x, at, 9, 5.2), 2) << x;
  }
}

double rms_of_samples(const OpenVolume& volume, const Source& s) {
  double squares = 0;
  for (uint32_t t = 0; t < s.dims[3]; ++t) {
    const std::vector<float> got = volume.frame(t);
    for (size_t i = 0; i < got.size(); ++i)
      squares += std::pow(double(got[i]) - s.values[t * s.frame_samples() + i], 2);
  }
  return std::sqrt(squares / double(s.values.size()));
}

// What a writer measures is what a reader gets, whichever base it takes: of a series of which a later frame
// has air, air; and a PSNR that the ripple would have broken is kept.
TEST(Constants, WhatIsMeasuredComesBack) {
  const TestDevice device;
  const Source whole = around(pressure, 50);
  Source part = whole;
  for (size_t i = 20 * whole.frame_samples(); i < part.values.size(); ++i)
    if (i % 22 < 8) part.values[i] = 0;
  for (const Source* s : {&whole, static_cast<const Source*>(&part)}) {
    auto options = sized<bccsplat_writer_options>();
    options.measure = BCCSPLAT_MEASURE_ALL;
    if (s == &whole) options.psnr = 50; // the ripple alone would leave 0
    const Written w = write_frames(device, *s, options);
    ASSERT_EQ(w.status, BCCSPLAT_OK) << w.text;
    const double rms = rms_of_samples(OpenVolume(device, w.bytes), *s);
    EXPECT_NEAR(w.error.rmse, rms, 0.01 * rms);
    if (s == &whole) {
      EXPECT_LT(rms, 0.5);
    } else {
      EXPECT_GT(rms, 50);
    }
  }
}

// The frames of a series, of one of them fewer planes or none at all: what no box covers is air.
Written with_gap(const TestDevice& device, const Source& s, uint32_t frame, uint32_t planes_left,
                 const bccsplat_writer_options& options) {
  return write_with(device, s, options, sized<bccsplat_channel_options>(),
                    [&](bccsplat_writer* w) -> bccsplat_status {
                      for (uint32_t t = 0; t < s.dims[3]; ++t) {
                        const Bytes data = frame_bytes(s, t);
                        auto box = sized<bccsplat_box>();
                        box.type = s.type, box.data = data.data();
                        for (size_t a = 0; a < 3; ++a) box.dims[a] = s.dims[a];
                        if (t == frame) box.dims[2] = planes_left;
                        const uint64_t boxes = box.dims[2] > 0 ? 1 : 0;
                        if (const bccsplat_status status = bccsplat_writer_add_frame(w, 0, t, &box, boxes))
                          return status;
                      }
                      return BCCSPLAT_OK;
                    });
}

// The field as a function, missing within a sample of a place near a corner.
int32_t ask_pressure(void* missing, uint64_t n, const double* p, float* values) {
  for (uint64_t i = 0; i < n; ++i, p += 4) {
    const bool hole =
        *static_cast<const bool*>(missing) && p[0] < 0.8 && p[1] < 0.8 && p[2] < 0.8 && p[3] < 0.8;
    values[i] = hole ? NAN : static_cast<float>(pressure + 50 * wave(p[0], p[1], p[2], p[3]));
  }
  return 0;
}

void expect_as_dense(const TestDevice& device, const Written& w, const char* what) {
  ASSERT_EQ(w.status, BCCSPLAT_OK) << what << w.text;
  const OpenVolume volume(device, w.bytes);
  const ConstantErrors e = errors_of(volume, pressure, 50);
  EXPECT_LT(e.rms, 0.25) << what;
  EXPECT_GT(e.gradient_db, 30) << what;
  EXPECT_LT(slice_rms(volume, in_time, pressure, 50), 0.25) << what;
  EXPECT_LT(slice_rms(volume, across_x, pressure, 50), 0.25) << what;
}

// A few samples that are air, whichever way they came to be, are no base for all others.
TEST(Constants, AFewThatAreAirLeaveTheOthersAlone) {
  const TestDevice device;
  const auto options = sized<bccsplat_writer_options>();
  auto hole = options, clamp = options;
  hole.nonfinite = BCCSPLAT_NONFINITE_HOLE, clamp.nonfinite = BCCSPLAT_NONFINITE_CLAMP;
  Source zero = around(pressure, 50), missing = zero;
  zero.values[0] = 0, missing.values[0] = NAN;
  expect_as_dense(device, write_frames(device, zero, options), "one sample of 0");
  expect_as_dense(device, write_frames(device, missing, clamp), "one NaN that becomes air");
  expect_as_dense(device, write_frames(device, missing, hole), "one NaN that is missing");
  expect_as_dense(device, with_gap(device, around(pressure, 50), 0, 19, options),
                  "a plane that no box covers");
  for (auto how : {hole, clamp}) {
    bool with_hole = true;
    const Written w =
        write_with(device, zero, how, sized<bccsplat_channel_options>(), [&](bccsplat_writer* writer) {
          return bccsplat_writer_add_field(writer, 0, ask_pressure, &with_hole);
        });
    expect_as_dense(device, w, "a field with a site left out");
    const OpenVolume volume(device, w.bytes);
    const float there = volume.at({{0, 0, 0, 0}})[0];
    if (how.nonfinite == BCCSPLAT_NONFINITE_HOLE) {
      EXPECT_TRUE(std::isnan(there));
    } else {
      EXPECT_LT(std::fabs(there), 0.3 * pressure);
    }
  }
}

// A frame that nobody gave is air, and no base for the others either.
TEST(Constants, AGapInTimeLeavesTheOthersAlone) {
  const TestDevice device;
  const Source s = source_of({22, 21, 20, 80}, BCCSPLAT_TYPE_F32, [](double x, double y, double z, double t) {
    return pressure + 50 * wave(x, y, z, t);
  });
  auto options = sized<bccsplat_writer_options>();
  options.measure = BCCSPLAT_MEASURE_ALL;
  const Written w = with_gap(device, s, 60, 0, options);
  expect_as_dense(device, w, "a frame without a box");
  EXPECT_GT(w.frames[60].rmse, 1000);
  for (uint32_t t = 0; t < 50; ++t) EXPECT_LT(w.frames[t].rmse, 1) << t; // as it comes back
}

// Corrections are differences from the field above a base that the file tells, and need be few.
TEST(Constants, BoundsHoldFarFromAir) {
  const TestDevice device;
  const auto check = [&](const Source& s, double bound, double constant, double signal,
                         const bccsplat_writer_options& how, double least_db, const char* what) {
    auto options = how;
    const Bytes free = stored(device, s, options);
    options.abs_error = bound;
    const Written w = write_frames(device, s, options);
    ASSERT_EQ(w.status, BCCSPLAT_OK) << what << w.text;
    EXPECT_LT(double(w.bytes.size()), 1.5 * double(free.size())) << what;
    const OpenVolume volume(device, w.bytes), unbound(device, free);
    const LargestError e = largest_error(volume, s);
    EXPECT_LE(e.slices, bound) << what;
    EXPECT_LE(e.points, bound) << what;
    EXPECT_NEAR(w.error.rmse, rms_of_samples(volume, s), 0.01 * w.error.rmse) << what;
    const ConstantErrors got = errors_of(volume, constant, signal);
    EXPECT_LT(got.rms, 1.2 * errors_of(unbound, constant, signal).rms + 0.01) << what;
    EXPECT_GT(got.gradient_db, least_db) << what;
    EXPECT_LT(slice_rms(volume, across_x, constant, signal), bound) << what;
    EXPECT_EQ(stored(TestDevice(1), s, options), w.bytes) << what; // whatever comes at once
  };
  const auto options = sized<bccsplat_writer_options>();
  auto cartesian = options, levels = options;
  cartesian.lattice = BCCSPLAT_LATTICE_CC;
  levels.levels = 1;
  check(around(pressure, 50), 2, pressure, 50, options, 30, "floats");
  check(around(pressure, 50, BCCSPLAT_TYPE_I32), 2, pressure, 50, options, 27, "i32");
  check(around(40000, 50, BCCSPLAT_TYPE_U16), 2, 40000, 50, options, 25, "u16");
  check(around(pressure, 50), 2, pressure, 50, cartesian, 20, "Cartesian");
  check(around(pressure, 50), 2, pressure, 50, levels, 30, "levels");
  check(around(2e9, 5e4, BCCSPLAT_TYPE_I32), 3000, 2e9, 5e4, options, 30, "2e9");
}

// And so do those of fields, and of data of which some are missing.
TEST(Constants, BoundsHoldBesideHolesAndInFields) {
  const TestDevice device;
  auto options = sized<bccsplat_writer_options>();
  options.abs_error = 2, options.nonfinite = BCCSPLAT_NONFINITE_HOLE;
  Source s = around(pressure, 50);
  bool with_hole = false;
  const auto channel = sized<bccsplat_channel_options>();
  const Written field = write_with(device, s, options, channel, [&](bccsplat_writer* writer) {
    return bccsplat_writer_add_field(writer, 0, ask_pressure, &with_hole);
  });
  expect_as_dense(device, field, "a field");
  EXPECT_LE(largest_error(OpenVolume(device, field.bytes), s).points, 2);
  for (size_t i = 0; i < s.values.size(); ++i)
    if (i % 22 >= 19 && i / 22 % 21 >= 18) s.values[i] = NAN;
  const Written holes = write_frames(device, s, options);
  expect_as_dense(device, holes, "holes");
  EXPECT_LE(largest_error(OpenVolume(device, holes.bytes), s).points, 2);
  // Of a turn the frames that are measured first are not the first ones.
  options.ends = BCCSPLAT_ENDS_PERIODIC;
  const Written round = write_frames(device, s, options);
  expect_as_dense(device, round, "a turn");
  EXPECT_LE(largest_error(OpenVolume(device, round.bytes), s).points, 2);
}

// Layers that a host samples itself, of pressures with air 0: the constant comes back, and waves about it.
TEST(Constants, LayersOfHostsComeBackFarFromAir) {
  const TestDevice device;
  for (const double signal : {0.0, 50.0}) {
    const auto options = sized<bccsplat_writer_options>();
    const auto feed = [&](bccsplat_writer* writer) {
      auto g = sized<bccsplat_layer_geometry>();
      for (int64_t m = 0; m == 0 || m < g.layer_count; ++m) {
        EXPECT_EQ(bccsplat_writer_get_layer_geometry(writer, m, &g), BCCSPLAT_OK);
        std::vector<float> samples;
        for (int64_t k = 0; k < g.dims[2]; ++k)
          for (int64_t j = 0; j < g.dims[1]; ++j)
            for (int64_t i = 0; i < g.dims[0]; ++i)
              samples.push_back(
                  static_cast<float>(pressure + signal * wave(g.origin[0] + g.step[0] * double(i),
                                                              g.origin[1] + g.step[1] * double(j),
                                                              g.origin[2] + g.step[2] * double(k), g.frame)));
        const bccsplat_status status =
            bccsplat_writer_add_layer(writer, 0, m, samples.data(), samples.size());
        if (status != BCCSPLAT_OK) return status;
      }
      return bccsplat_status{BCCSPLAT_OK};
    };
    const Source s = around(pressure, signal);
    const Written w = write_with(device, s, options, sized<bccsplat_channel_options>(), feed);
    ASSERT_EQ(w.status, BCCSPLAT_OK) << w.text;
    const OpenVolume volume(device, w.bytes);
    const double ripple = 0.0024 * pressure;
    EXPECT_LT(errors_of(volume, pressure, signal).rms, signal > 0 ? 1 : 1e-5 * pressure) << signal;
    EXPECT_LT(slice_rms(volume, in_time, pressure, signal), 0.01 * ripple) << signal;
    const Cut cut(volume, in_time);
    const std::vector<float> values = picture(device, cut, BCCSPLAT_MODE_MAXIMUM, BCCSPLAT_FRAME_VALUE);
    EXPECT_LT(largest_difference(values, pressure), signal + 0.1 * ripple) << signal;
  }
}

// A series that is taken up again has the base of one written undisturbed.
TEST(Constants, ResumedFarFromAir) {
  const TestDevice device;
  const Source s =
      source_of({22, 21, 20, 50}, BCCSPLAT_TYPE_F32,
                [&](double x, double y, double z, double t) { return pressure + 50 * wave(x, y, z, t); });
  const std::string path =
      (std::filesystem::temp_directory_path() / ("bccsplat-far-" + std::to_string(::getpid()))).string();
  auto options = sized<bccsplat_writer_options>();
  options.partial = BCCSPLAT_PARTIAL_RESUME, options.overwrite = 1;
  std::copy(s.dims.begin(), s.dims.end(), options.dims);
  auto report = sized<bccsplat_writer_report>();
  const auto write = [&](uint32_t frames) {
    bccsplat_writer* writer = nullptr;
    ASSERT_EQ(bccsplat_writer_create(device.device, path.c_str(), &options, &writer), BCCSPLAT_OK)
        << bccsplat_last_error();
    for (uint32_t t = 0; t < frames; ++t) {
      const Bytes data = frame_bytes(s, t);
      auto box = sized<bccsplat_box>();
      box.type = s.type, box.data = data.data();
      for (size_t a = 0; a < 3; ++a) box.dims[a] = s.dims[a];
      // What is written is recorded once a second.
      if (frames < s.dims[3] && t == 26) std::this_thread::sleep_for(std::chrono::milliseconds(1100));
      EXPECT_EQ(bccsplat_writer_add_frame(writer, 0, t, &box, 1), BCCSPLAT_OK) << bccsplat_last_error();
    }
    if (frames == s.dims[3]) {
      EXPECT_EQ(bccsplat_writer_finish(writer, &report), BCCSPLAT_OK) << bccsplat_last_error();
    }
    bccsplat_writer_release(writer);
  };
  write(36);
  write(50);
  EXPECT_GT(report.slabs_reused, 0u);
  std::ifstream in(path, std::ios::binary);
  const Bytes resumed{std::istreambuf_iterator<char>(in), {}};
  in.close();
  std::filesystem::remove(path);
  options.partial = 0;
  EXPECT_EQ(resumed, stored(device, s, options));
  const ConstantErrors e = errors_of(OpenVolume(device, resumed), pressure, 50);
  EXPECT_LT(e.rms, 1);
  EXPECT_GT(e.gradient_db, 30);
}

} // namespace
} // namespace bccsplat::test
