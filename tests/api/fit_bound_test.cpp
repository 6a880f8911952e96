// SPDX-License-Identifier: Apache-2.0
// Bounds of the error at the source samples: what the writer promises is what every reader finds.
#include <random>

#include "fit_writer.h"

namespace bccsplat::test {
namespace {

constexpr double nan_value = std::numeric_limits<double>::quiet_NaN();

double bound_wave(double x, double y, double z, double t) {
  return std::sin(0.7 * x + 0.3 * y) * std::cos(0.4 * z - 0.5 * t) + 0.2 * std::sin(1.1 * y + 0.6 * t);
}

struct Case {
  const char* name;
  Source source;
  double range;
  double largest = 0; // magnitude, where it is much more than the range
};

std::vector<Case> cases() {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto noise = [&](double, double, double, double) { return uniform(random); };
  const auto box = [](double x, double y, double z, double t) { // hard edges in air
    return std::fabs(x - 5 - t) < 2.5 && std::fabs(y - 6) < 3 && std::fabs(z - 4) < 2 ? 3.0 : 0.0;
  };
  const auto torn = [](double x, double y, double z, double t) { // a block of missing data, and single ones
    if ((x >= 4 && x < 8 && y >= 4 && y < 7 && z > 3 && t > 1) || (x == 1 && y == 2)) return nan_value;
    return bound_wave(x, y, z, t);
  };
  std::vector<Case> list;
  list.push_back({"wave f32", source_of({12, 11, 9, 7}, BCCSPLAT_TYPE_F32, bound_wave), 2.4});
  list.push_back(
      {"wave f64, far from 0",
       source_of({9, 10, 8, 6}, BCCSPLAT_TYPE_F64, [](auto... p) { return 1e5 + 100 * bound_wave(p...); }),
       240, 100120});
  list.push_back({"noise f32", source_of({10, 9, 8, 6}, BCCSPLAT_TYPE_F32, noise), 2});
  list.push_back({"box in air f32", source_of({16, 13, 9, 6}, BCCSPLAT_TYPE_F32, box), 3});
  list.push_back({"holes f32", source_of({12, 11, 9, 6}, BCCSPLAT_TYPE_F32, torn), 2.4});
  list.push_back(
      {"noise u8",
       source_of({9, 8, 9, 5}, BCCSPLAT_TYPE_U8, [&](auto... p) { return 128 + 120 * noise(p...); }), 240});
  list.push_back(
      {"wave i16",
       source_of({9, 8, 9, 5}, BCCSPLAT_TYPE_I16, [](auto... p) { return 9000 * bound_wave(p...); }), 21600});
  list.push_back({"wave u16, air 700",
                  source_of({9, 8, 9, 5}, BCCSPLAT_TYPE_U16,
                            [](auto... p) { return std::max(700.0, 9000 * bound_wave(p...)); }),
                  10000});
  list.back().source.air = 700;
  list.back().source.threshold = 40;
  list.push_back({"noise i32",
                  source_of({8, 8, 7, 4}, BCCSPLAT_TYPE_I32, [&](auto... p) { return 30000 * noise(p...); }),
                  60000});
  list.push_back({"static", source_of({12, 9, 11, 1}, BCCSPLAT_TYPE_F32, noise), 2});
  return list;
}

TEST(Bound, HoldsAtEverySourceSampleOfEveryField) {
  const TestDevice device;
  for (const Case& c : cases())
    for (const double part : {0.3, 0.02, 5e-4, 2e-5})
      for (const int32_t lattice : {BCCSPLAT_LATTICE_DEFAULT, BCCSPLAT_LATTICE_CC}) {
        SCOPED_TRACE(std::string(c.name) + ", bound " + std::to_string(part * c.range) + ", lattice " +
                     std::to_string(lattice));
        auto options = sized<bccsplat_writer_options>();
        options.abs_error = part * c.range;
        options.lattice = lattice;
        options.nonfinite = BCCSPLAT_NONFINITE_HOLE;
        const Written w = write_frames(device, c.source, options);
        if (options.abs_error < c.largest * 0x1p-20) { // too little for 32-bit floats of that size
          EXPECT_TRUE(w.status == BCCSPLAT_OK || w.status == BCCSPLAT_ERROR_BOUND_NOT_MET) << w.text;
          if (w.status != BCCSPLAT_OK) continue;
        }
        ASSERT_EQ(w.status, BCCSPLAT_OK) << w.text;
        const OpenVolume volume(device, w.bytes);
        ASSERT_EQ(volume.status, BCCSPLAT_OK) << bccsplat_last_error();
        auto info = sized<bccsplat_channel_info>();
        ASSERT_EQ(bccsplat_volume_get_channel_info(volume.volume, 0, &info), BCCSPLAT_OK);
        EXPECT_EQ(info.error_bound, options.abs_error);
        const LargestError e = largest_error(volume, c.source);
        EXPECT_LE(e.slices, options.abs_error);
        EXPECT_LE(e.points, options.abs_error);
        // The report is what a reader finds, to the last bit.
        EXPECT_EQ(w.error.max_abs, e.slices);
        EXPECT_EQ(w.report.frames_measured, c.source.dims[3]);
        EXPECT_EQ(w.error.lost, 0u);
        auto verified = sized<bccsplat_verify_report>();
        ASSERT_EQ(bccsplat_volume_verify(volume.volume, nullptr, nullptr, &verified), BCCSPLAT_OK);
        EXPECT_EQ(verified.damages, 0u);
      }
}

TEST(Bound, CorrectsOnlyWhatMisses) {
  const TestDevice device;
  const Source s = cases()[2].source; // noise
  auto options = sized<bccsplat_writer_options>();
  options.measure = BCCSPLAT_MEASURE_ALL;
  const Written plain = write_frames(device, s, options);
  ASSERT_EQ(plain.status, BCCSPLAT_OK);
  EXPECT_EQ(plain.report.corrected, 0u);
  options.abs_error = plain.error.max_abs * 1.01;
  const Written loose = write_frames(device, s, options);
  EXPECT_EQ(loose.report.corrected, 0u);
  EXPECT_EQ(loose.report.bytes_corrections, 0u);
  options.abs_error = plain.error.rmse;
  const Written tight = write_frames(device, s, options);
  EXPECT_EQ(tight.error.uncorrected_max_abs, plain.error.max_abs);
  EXPECT_GT(tight.report.corrected, s.values.size() / 10);
  EXPECT_LT(tight.report.corrected, s.values.size() / 2); // of a normal distribution 32 % miss
  EXPECT_GT(tight.report.bytes_corrections, 0u);
  EXPECT_LT(tight.error.rmse, plain.error.rmse);
}

TEST(Bound, IsRefusedWhereFloatsCannotHoldIt) {
  const TestDevice device;
  const Source s = source_of({9, 8, 7, 5}, BCCSPLAT_TYPE_F64, [](double x, double y, double z, double t) {
    return 1e6 + 30 * bound_wave(x, y, 3 * z, 2 * t);
  });
  auto options = sized<bccsplat_writer_options>();
  options.abs_error = 0.01; // floats near 1e6 are 1/16 apart
  const Written w = write_frames(device, s, options);
  EXPECT_EQ(w.status, BCCSPLAT_ERROR_BOUND_NOT_MET);
  for (const char* part : {"frame", "voxel (", "bound of 0.01", "32-bit floats"})
    EXPECT_NE(w.text.find(part), std::string::npos) << w.text;
  options.abs_error = 2;
  EXPECT_EQ(write_frames(device, s, options).status, BCCSPLAT_OK);
}

// No bound would keep a PSNR beyond what floats hold: the text names what they do.
TEST(Bound, OfPsnrBeyondFloatsSaysHowMuchTheyHold) {
  const TestDevice device;
  const Source s = source_of({9, 8, 7, 5}, BCCSPLAT_TYPE_F64, [](double x, double y, double z, double t) {
    return 1e6 + 30 * bound_wave(x, y, 3 * z, 2 * t);
  });
  auto options = sized<bccsplat_writer_options>();
  options.psnr = 70;
  const Written bad = write_frames(device, s, options);
  EXPECT_EQ(bad.status, BCCSPLAT_ERROR_BOUND_NOT_MET);
  EXPECT_EQ(bad.text.find("abs_error"), std::string::npos) << bad.text;
  const std::string asks = "ask for at most ";
  const size_t at = bad.text.find(asks);
  ASSERT_NE(at, std::string::npos) << bad.text;
  // As much can be had, with the bound that goes with it.
  options.psnr = std::strtod(bad.text.c_str() + at + asks.size(), nullptr) - 0.01;
  EXPECT_GT(options.psnr, 30);
  options.measure = BCCSPLAT_MEASURE_ALL;
  options.abs_error = 1.5 * 2 * 30 * std::pow(10, -options.psnr / 20);
  const Written good = write_frames(device, s, options);
  EXPECT_EQ(good.status, BCCSPLAT_OK) << good.text;
}

TEST(Bound, OfPsnrHoldsOrIsRefusedWithTheReason) {
  const TestDevice device;
  const Source s = cases()[0].source;
  auto options = sized<bccsplat_writer_options>();
  options.measure = BCCSPLAT_MEASURE_ALL;
  const double reached = write_frames(device, s, options).error.psnr;
  options.psnr = reached - 0.01;
  const Written good = write_frames(device, s, options);
  EXPECT_EQ(good.status, BCCSPLAT_OK) << good.text;
  EXPECT_EQ(good.error.psnr, reached);
  options.psnr = reached + 0.01;
  const Written bad = write_frames(device, s, options);
  EXPECT_EQ(bad.status, BCCSPLAT_ERROR_BOUND_NOT_MET);
  for (const char* part : {"dB reached", "frame", "voxel", "scale", "CC", "abs_error"})
    EXPECT_NE(bad.text.find(part), std::string::npos) << bad.text;
  // The way out the text names.
  options.abs_error = 1.5 * good.error.peak * std::pow(10, -(reached + 3) / 20), options.psnr = reached + 3;
  EXPECT_EQ(write_frames(device, s, options).status, BCCSPLAT_OK);
}

// Between source samples corrections fall off along each axis as (1 - d)^2 (1 + 2 d).
TEST(Bound, CorrectionsAreContinuousBetweenSamples) {
  const TestDevice device;
  const Source s = cases()[2].source;
  auto options = sized<bccsplat_writer_options>();
  const Written plain = write_frames(device, s, options);
  options.abs_error = 0.1;
  const Written fixed = write_frames(device, s, options);
  const OpenVolume a(device, plain.bytes), b(device, fixed.bytes);
  std::vector<double> difference; // at the source samples
  for (uint32_t t = 0; t < s.dims[3]; ++t) {
    const auto before = a.frame(t), after = b.frame(t);
    for (size_t i = 0; i < before.size(); ++i) difference.push_back(double(after[i]) - double(before[i]));
  }
  std::mt19937 random(3);
  std::vector<std::array<double, 4>> points;
  for (int i = 0; i < 500; ++i) {
    std::array<double, 4> p{};
    for (size_t k = 0; k < 4; ++k) p[k] = std::uniform_real_distribution<double>(0, s.dims[k] - 1.0)(random);
    points.push_back(p);
  }
  const auto without = a.at(points), with = b.at(points);
  for (size_t i = 0; i < points.size(); ++i) {
    double expected = 0;
    for (int corner = 0; corner < 16; ++corner) {
      double w = 1;
      size_t at = 0;
      for (size_t k = 4; k-- > 0;) {
        const double cell = std::floor(points[i][k]) + (corner >> k & 1);
        const double d = std::fabs(points[i][k] - cell);
        w *= (1 - d) * (1 - d) * (1 + 2 * d);
        at = at * s.dims[k] + static_cast<size_t>(cell);
      }
      if (w > 0) expected += w * difference[at];
    }
    EXPECT_NEAR(double(with[i]) - double(without[i]), expected, 2e-6);
  }
  // A slice between frames, on a finer grid, shows the same field.
  auto plane = sized<bccsplat_hyperplane>();
  plane.d = 1, plane.e = -2.25;
  bccsplat_slice* slice = nullptr;
  ASSERT_EQ(bccsplat_slice_create(b.volume, &plane, nullptr, &slice), BCCSPLAT_OK);
  auto grid = sized<bccsplat_grid>();
  grid.origin[0] = 0.3, grid.origin[1] = 5.5, grid.origin[2] = 6.9;
  grid.step[0] = 0.4, grid.step[1] = -0.7, grid.step[2] = -0.35;
  grid.dims[0] = 11, grid.dims[1] = 6, grid.dims[2] = 9;
  std::vector<float> dense(11 * 6 * 9), points_of_slice(dense.size());
  ASSERT_EQ(bccsplat_slice_sample_grid(slice, &grid, dense.data()), BCCSPLAT_OK);
  std::vector<std::array<double, 4>> same;
  std::vector<double> uvw;
  for (int k = 0; k < 9; ++k)
    for (int j = 0; j < 6; ++j)
      for (int i = 0; i < 11; ++i) {
        same.push_back({0.3 + 0.4 * i, 5.5 - 0.7 * j, 6.9 - 0.35 * k, 2.25});
        uvw.insert(uvw.end(), {same.back()[0], same.back()[1], same.back()[2]});
      }
  const auto at = b.at(same);
  ASSERT_EQ(bccsplat_slice_evaluate(slice, same.size(), uvw.data(), points_of_slice.data(), nullptr),
            BCCSPLAT_OK);
  for (size_t i = 0; i < at.size(); ++i) {
    EXPECT_NEAR(dense[i], at[i], 3e-6);
    EXPECT_NEAR(points_of_slice[i], at[i], 3e-6);
  }
  bccsplat_slice_release(slice);
}

TEST(Bound, CorrectionsBelongToTheirKernelAlone) {
  const TestDevice device;
  const Source s = cases()[2].source;
  auto options = sized<bccsplat_writer_options>();
  const Written plain = write_frames(device, s, options);
  options.abs_error = 0.1;
  const Written fixed = write_frames(device, s, options);
  const OpenVolume a(device, plain.bytes, "fine"), b(device, fixed.bytes, "fine");
  EXPECT_EQ(a.frame(2), b.frame(2));
  const OpenVolume c(device, plain.bytes), d(device, fixed.bytes);
  EXPECT_NE(c.frame(2), d.frame(2));
}

TEST(Bound, ThreadsChangeNoByte) {
  const Source s = cases()[4].source;
  auto options = sized<bccsplat_writer_options>();
  options.abs_error = 0.05;
  options.nonfinite = BCCSPLAT_NONFINITE_HOLE;
  const Written one = write_frames(TestDevice(1), s, options),
                three = write_frames(TestDevice(3), s, options);
  EXPECT_EQ(one.bytes, three.bytes);
  EXPECT_EQ(one.error.rmse, three.error.rmse);
  EXPECT_EQ(one.report.coding_rmse, three.report.coding_rmse);
}

TEST(Bound, NeedsFramesAndTheirNumber) {
  const TestDevice device;
  Source s = cases()[0].source;
  auto options = sized<bccsplat_writer_options>();
  options.abs_error = -1;
  EXPECT_EQ(write_frames(device, s, options).status, BCCSPLAT_ERROR_INVALID_ARGUMENT);
  options.abs_error = nan_value;
  EXPECT_EQ(write_frames(device, s, options).status, BCCSPLAT_ERROR_INVALID_ARGUMENT);
  options.abs_error = 0.1;
  s.dims[3] = 0;
  EXPECT_EQ(write_frames(device, s, options).status, BCCSPLAT_ERROR_INVALID_ARGUMENT);
}

TEST(Measure, SaysWhatTheFileIsWorthFrameByFrame) {
  const TestDevice device;
  const Source s = cases()[0].source;
  auto options = sized<bccsplat_writer_options>();
  options.measure = BCCSPLAT_MEASURE_ALL;
  const Written w = write_frames(device, s, options);
  const OpenVolume volume(device, w.bytes);
  double squares = 0, low = 1e9, high = -1e9, largest = 0;
  for (uint32_t t = 0; t < s.dims[3]; ++t) {
    const auto got = volume.frame(t);
    double sum = 0, most = 0;
    for (size_t i = 0; i < got.size(); ++i) {
      const double want = s.values[t * got.size() + i], d = double(got[i]) - want;
      sum += d * d, most = larger(most, std::fabs(d));
      low = std::min(low, want), high = std::max(high, want);
    }
    EXPECT_EQ(w.frames[t].frame, t);
    EXPECT_EQ(w.frames[t].max_abs, most);
    EXPECT_NEAR(w.frames[t].rmse, std::sqrt(sum / double(got.size())), 1e-12);
    squares += sum, largest = larger(largest, most);
  }
  EXPECT_EQ(w.error.max_abs, largest);
  EXPECT_EQ(w.error.peak, high - low);
  EXPECT_NEAR(w.error.psnr, 10 * std::log10(std::pow(high - low, 2) * double(s.values.size()) / squares),
              1e-9);
  const auto worst = volume.frame(double(w.error.frame));
  const size_t at = (w.error.voxel[2] * s.dims[1] + w.error.voxel[1]) * s.dims[0] + w.error.voxel[0];
  EXPECT_EQ(double(worst[at]), w.error.got);
  EXPECT_EQ(std::fabs(w.error.got - w.error.expected), largest);

  options.measure = BCCSPLAT_MEASURE_SOME;
  const Written some = write_frames(device, s, options);
  ASSERT_EQ(some.report.frames_measured, 3u);
  EXPECT_EQ(some.bytes, w.bytes);
  for (const auto& f : some.frames) EXPECT_EQ(f.rmse, w.frames[f.frame].rmse);
}

// A kernel that the Cartesian lattice lacks, and memory that is short, end what nobody insisted on.
TEST(Measure, OfSomeFramesGivesWay) {
  const TestDevice device;
  const Source s = cases()[0].source;
  auto options = sized<bccsplat_writer_options>();
  options.lattice = BCCSPLAT_LATTICE_CC, options.recommended_kernel = "fine";
  options.measure = BCCSPLAT_MEASURE_SOME;
  const Written some = write_frames(device, s, options);
  EXPECT_EQ(some.status, BCCSPLAT_OK) << some.text;
  EXPECT_EQ(some.report.frames_measured, 0u);
  options.measure = BCCSPLAT_MEASURE_ALL;
  EXPECT_EQ(write_frames(device, s, options).status, BCCSPLAT_ERROR_UNSUPPORTED);
}

// Stored as f32 nothing but dropped sites differs; as u8 half a step.
TEST(Measure, CodingErrorIsThatOfTheStoredType) {
  const TestDevice device;
  const Source s = cases()[0].source;
  auto channel = sized<bccsplat_channel_options>();
  const auto options = sized<bccsplat_writer_options>();
  EXPECT_EQ(write_frames(device, s, options, channel).report.coding_max, 0);
  channel.value_type = BCCSPLAT_TYPE_U16, channel.set_mask = BCCSPLAT_CHANNEL_SET_RANGE;
  channel.range[0] = -2, channel.range[1] = 2;
  channel.value_step = 0.01;
  const Written w = write_frames(device, s, options, channel);
  ASSERT_EQ(w.status, BCCSPLAT_OK) << w.text;
  EXPECT_NEAR(w.report.coding_max, 0.005, 1e-4);
  EXPECT_NEAR(w.report.coding_rmse, 0.01 / std::sqrt(12), 2e-4);
  const OpenVolume volume(device, w.bytes);
  auto info = sized<bccsplat_channel_info>();
  ASSERT_EQ(bccsplat_volume_get_channel_info(volume.volume, 0, &info), BCCSPLAT_OK);
  EXPECT_EQ(info.value_scale, 0.01);
  EXPECT_EQ(std::nearbyint(-info.value_offset / 0.01), -info.value_offset / 0.01); // air has a code
  channel.value_step = 1e-6;                                                       // too many codes
  EXPECT_EQ(write_frames(device, s, options, channel).status, BCCSPLAT_ERROR_INVALID_ARGUMENT);
}

} // namespace
} // namespace bccsplat::test
