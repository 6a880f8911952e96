// SPDX-License-Identifier: Apache-2.0
// Series stored as wavelets: the error that was asked for at every level of asking, and what is refused.
#include <algorithm>

#include "fit_writer.h"

namespace bccsplat::test {
namespace {

double moving_waves(double x, double y, double z, double t) {
  return 900 * std::sin(.21 * x + .13 * y - .3 * t) * std::cos(.17 * z + .1 * t) +
         60 * std::sin(1.9 * x + 2.3 * z);
}

// As u16 over the range of the source, on its own grid.
struct Asked {
  Asked() {
    options.store = BCCSPLAT_STORE_WAVELETS, options.lattice = BCCSPLAT_LATTICE_CC;
    options.measure = BCCSPLAT_MEASURE_ALL;
    channel.value_type = BCCSPLAT_TYPE_U16, channel.set_mask = BCCSPLAT_CHANNEL_SET_RANGE;
    channel.range[0] = -960, channel.range[1] = 960;
  }
  bccsplat_writer_options options = sized<bccsplat_writer_options>();
  bccsplat_channel_options channel = sized<bccsplat_channel_options>();
};

Source waves_in_time() { return source_of({37, 30, 25, 20}, BCCSPLAT_TYPE_F32, moving_waves); }

double root_mean_square(const OpenVolume& volume, const Source& s) {
  double sum = 0;
  for (uint32_t t = 0; t < s.dims[3]; ++t) {
    const std::vector<float> frame = volume.frame(t);
    for (size_t i = 0; i < frame.size(); ++i) sum += std::pow(frame[i] - s.values[t * frame.size() + i], 2);
  }
  return std::sqrt(sum / static_cast<double>(s.values.size()));
}

TEST(Wavelets, KeepAnErrorAPsnrAndABound) {
  const TestDevice device;
  const Source s = waves_in_time();
  size_t last = SIZE_MAX;
  for (const double error : {1.0, 4.0, 16.0}) {
    Asked a;
    a.options.wavelet_errors = &error;
    const Written w = write_frames(device, s, a.options, a.channel);
    ASSERT_EQ(w.status, BCCSPLAT_OK) << w.text;
    const OpenVolume volume(device, w.bytes);
    const double found = root_mean_square(volume, s);
    EXPECT_LE(found, error * 1.001);
    EXPECT_GT(found, error * .7);
    EXPECT_NEAR(w.error.rmse, found, .01 * found); // what was told while it was written
    EXPECT_LT(w.bytes.size(), last);
    last = w.bytes.size();
    auto info = sized<bccsplat_volume_info>();
    ASSERT_EQ(bccsplat_volume_get_info(volume.volume, &info), BCCSPLAT_OK);
    EXPECT_EQ(info.store, BCCSPLAT_STORE_WAVELETS);
  }
  Asked a;
  a.options.psnr = 55;
  const Written psnr = write_frames(device, s, a.options, a.channel);
  ASSERT_EQ(psnr.status, BCCSPLAT_OK) << psnr.text;
  EXPECT_GE(psnr.error.psnr, 55);
  EXPECT_LT(psnr.error.psnr, 57);
  Asked b;
  b.options.abs_error = 6;
  const Written bound = write_frames(device, s, b.options, b.channel);
  ASSERT_EQ(bound.status, BCCSPLAT_OK) << bound.text;
  const LargestError largest = largest_error(OpenVolume(device, bound.bytes), s);
  EXPECT_LE(largest.slices, 6);
  EXPECT_LE(largest.points, 6);
}

// Values far from air, where none is left out: the field has a base among them, tiles are told from air.
TEST(Wavelets, FarFromAirAreWhereTheyWere) {
  const TestDevice device;
  const Source s = source_of({24, 23, 22, 9}, BCCSPLAT_TYPE_F32, [](double x, double y, double z, double t) {
    return 1000 + 40 * std::sin(.3 * x + .2 * y - .3 * t) * std::cos(.2 * z);
  });
  for (const double low : {0.0, 900.0}) { // of the range: air has a code, or lies beyond them
    Asked a;
    const double error = 1;
    a.options.wavelet_errors = &error;
    a.channel.range[0] = low, a.channel.range[1] = 1100;
    const Written w = write_frames(device, s, a.options, a.channel);
    ASSERT_EQ(w.status, BCCSPLAT_OK) << w.text;
    const OpenVolume volume(device, w.bytes);
    EXPECT_LE(root_mean_square(volume, s), 1.01);
    std::vector<float> frame(s.frame_samples());
    ASSERT_EQ(bccsplat_volume_read_frame(volume.volume, 0, 4, nullptr, nullptr, frame.data()), BCCSPLAT_OK);
    EXPECT_LT(largest_difference(frame, volume.frame(4)), .02);
  }
}

// Values that are hard for small errors: far from air, of which there is some.
struct Hard {
  const char* name;
  int32_t type;          // of the source
  bccsplat_type stored;  // as
  double low, high, top; // of the range that is told; values lie below the top
  double width;          // by so much
  [[nodiscard]] Source source() const {
    const double t0 = top, w = width;
    return source_of({34, 33, 9, 24}, type, [=](double x, double y, double z, double t) {
      if (x < 5) return 0.0;
      return t0 - w * (1 + std::sin(.31 * x + .23 * y - .4 * t) * std::cos(.27 * z + .1 * t)) / 2;
    });
  }
  [[nodiscard]] double code() const { return (high - low) / (stored == BCCSPLAT_TYPE_U8 ? 255 : 65535); }
  [[nodiscard]] bool is_exact() const { return type != BCCSPLAT_TYPE_F32; }
  // What is found in a file that keeps an error: readers calculate in floats.
  [[nodiscard]] double found(double error) const {
    return std::hypot(error, 2e-6 * std::max(std::fabs(low), std::fabs(high)));
  }
};

const Hard hard_values[] = {
    {"near the top", BCCSPLAT_TYPE_F32, BCCSPLAT_TYPE_U16, 0, 1, .92, .04},
    {"the whole range", BCCSPLAT_TYPE_F32, BCCSPLAT_TYPE_U16, 0, 1, 1, 1},
    {"narrow, far from zero", BCCSPLAT_TYPE_F32, BCCSPLAT_TYPE_U16, 0, 1001, 1000, .5},
    {"below zero", BCCSPLAT_TYPE_F32, BCCSPLAT_TYPE_U16, -8, 0, -7, .4},
    {"in bytes", BCCSPLAT_TYPE_F32, BCCSPLAT_TYPE_U8, 0, 1, .95, .2},
    {"words", BCCSPLAT_TYPE_U16, BCCSPLAT_TYPE_U16, 0, 65535, 65000, 900},
    {"bytes", BCCSPLAT_TYPE_U8, BCCSPLAT_TYPE_U8, 0, 255, 250, 90},
};

Asked asked_of(const Hard& h, bccsplat_lattice lattice = BCCSPLAT_LATTICE_CC) {
  Asked a;
  a.options.lattice = lattice, a.channel.value_type = h.stored;
  if (h.is_exact()) a.channel.set_mask = 0; // codes are the source's own
  a.channel.range[0] = h.low, a.channel.range[1] = h.high;
  return a;
}

// Of frames first .. end - 1.
double root_mean_square(const OpenVolume& volume, const Source& s, uint32_t first, uint32_t end) {
  double sum = 0;
  for (uint32_t t = first; t < end; ++t) {
    const std::vector<float> frame = volume.frame(t);
    for (size_t i = 0; i < frame.size(); ++i) sum += std::pow(frame[i] - s.values[t * frame.size() + i], 2);
  }
  return std::sqrt(sum / (static_cast<double>(s.frame_samples()) * (end - first)));
}

TEST(Wavelets, ASmallErrorIsKeptInEverySlabOrRefused) {
  const TestDevice device;
  for (const Hard& h : hard_values) {
    const Source s = h.source();
    for (double error = .1 * (h.high - h.low); error > .5e-7 * (h.high - h.low); error /= 10) {
      Asked a = asked_of(h);
      a.options.wavelet_errors = &error;
      const Written w = write_frames(device, s, a.options, a.channel);
      const std::string what = std::string(h.name) + ", " + std::to_string(error / h.code()) + " codes";
      // Codes are off by the root of a twelfth of themselves.
      const bool kept = h.is_exact() || error > .3 * h.code(), missed = !kept && error < .2 * h.code();
      EXPECT_FALSE(kept && w.status != BCCSPLAT_OK) << what << ": " << w.text;
      EXPECT_FALSE(missed && w.status != BCCSPLAT_ERROR_BOUND_NOT_MET) << what << ": " << w.status;
      if (w.status != BCCSPLAT_OK) {
        EXPECT_NE(w.text.find("slab 0"), std::string::npos) << w.text; // as early as that
        continue;
      }
      const OpenVolume volume(device, w.bytes);
      const double first = root_mean_square(volume, s, 0, 16), last = root_mean_square(volume, s, 16, 24);
      EXPECT_LE(first, 1.001 * h.found(error)) << what; // 16 layers
      EXPECT_LE(last, 1.001 * h.found(error)) << what;  // eight
    }
  }
}

// What is read of bytes is near them without having been rounded to bytes, which errs less; just beside a
// frame it is the same.
TEST(Wavelets, SamplesOfTheGridAreNotRounded) {
  const TestDevice device;
  const Source s = hard_values[6].source();
  const double error = 1.5;
  Asked a = asked_of(hard_values[6]);
  a.options.wavelet_errors = &error;
  const Written w = write_frames(device, s, a.options, a.channel);
  ASSERT_EQ(w.status, BCCSPLAT_OK) << w.text;
  const OpenVolume volume(device, w.bytes);
  double plain = 0, rounded = 0;
  for (uint32_t t = 0; t < s.dims[3]; ++t) {
    const std::vector<float> frame = volume.frame(t);
    for (size_t i = 0; i < frame.size(); ++i) {
      const double source = s.values[t * frame.size() + i];
      plain += std::pow(frame[i] - source, 2), rounded += std::pow(std::nearbyint(frame[i]) - source, 2);
    }
  }
  EXPECT_LT(plain * 1.02, rounded);
  std::vector<double> points;
  for (const double t : {7.0, 7 + 1e-6, 16.0, 16 - 1e-6}) // also at the end of a slab
    for (int i = 0; i < 200; ++i)
      points.insert(points.end(), {i % 34 * 1.0, i * 7 % 33 * 1.0, i % 9 * 1.0, t});
  std::vector<float> values(points.size() / 4);
  ASSERT_EQ(bccsplat_volume_evaluate(volume.volume, values.size(), points.data(), values.data(), nullptr),
            BCCSPLAT_OK);
  for (size_t i = 0; i < 200; ++i) {
    EXPECT_NEAR(values[i], values[200 + i], 2e-3);
    EXPECT_NEAR(values[400 + i], values[600 + i], 2e-3);
  }
}

TEST(Wavelets, AHighPsnrIsReachedOrRefused) {
  const TestDevice device;
  for (const Hard& h : hard_values)
    for (const bccsplat_lattice lattice : {BCCSPLAT_LATTICE_CC, BCCSPLAT_LATTICE_D4STAR}) {
      const Source s = h.source();
      const auto [low, high] = std::minmax_element(s.values.begin(), s.values.end());
      for (const double psnr : {40., 60., 80., 90., 120.}) {
        Asked a = asked_of(h, lattice);
        if (h.is_exact()) a.channel.set_mask = BCCSPLAT_CHANNEL_SET_RANGE;
        a.options.psnr = psnr;
        const Written w = write_frames(device, s, a.options, a.channel);
        const std::string what = std::string(h.name) + ", " + std::to_string(psnr) + " dB";
        const double error = (h.high - h.low) / std::pow(10, psnr / 20);
        const bool kept =
            lattice == BCCSPLAT_LATTICE_CC && *high - *low > .99 * (h.high - h.low) && error > .4 * h.code();
        EXPECT_FALSE(kept && w.status != BCCSPLAT_OK) << what << ": " << w.text;
        if (w.status != BCCSPLAT_OK) {
          EXPECT_EQ(w.status, BCCSPLAT_ERROR_BOUND_NOT_MET) << what << ": " << w.text;
          continue;
        }
        const double found = root_mean_square(OpenVolume(device, w.bytes), s);
        EXPECT_GE(20 * std::log10((*high - *low) / found), psnr) << what;
        EXPECT_NEAR(w.error.rmse, found, .01 * found + h.found(0)) << what;
      }
    }
}

// Corrections keep what codes cannot.
TEST(Wavelets, ASmallBoundIsKeptOrRefused) {
  const TestDevice device;
  for (const Hard& h : hard_values) {
    const Source s = h.source();
    for (const double share : {1e-2, 1e-4, 1e-5, 1e-6}) {
      Asked a = asked_of(h);
      a.options.abs_error = share * (h.high - h.low);
      const Written w = write_frames(device, s, a.options, a.channel);
      const std::string what = std::string(h.name) + ", " + std::to_string(share);
      EXPECT_FALSE(share > 1e-6 && w.status != BCCSPLAT_OK) << what << ": " << w.text;
      if (w.status != BCCSPLAT_OK) {
        EXPECT_EQ(w.status, BCCSPLAT_ERROR_BOUND_NOT_MET) << what << ": " << w.text;
        continue;
      }
      EXPECT_LE(largest_error(OpenVolume(device, w.bytes), s).slices, a.options.abs_error) << what;
    }
  }
}

TEST(Wavelets, TakeAFractionOfTheBytesOfSamples) {
  const TestDevice device;
  const Source s = waves_in_time();
  Asked a;
  a.options.psnr = 50;
  const Written wavelets = write_frames(device, s, a.options, a.channel);
  // 5.4 is the root mean square of a step of 18.7: samples in steps that make the same error.
  a.options.store = BCCSPLAT_STORE_SAMPLES, a.channel.value_step = 18.7;
  const Written samples = write_frames(device, s, a.options, a.channel);
  ASSERT_EQ(samples.status, BCCSPLAT_OK) << samples.text;
  EXPECT_GE(wavelets.error.psnr, 50);
  EXPECT_LT(samples.error.psnr, 51.5);
  EXPECT_LT(2 * wavelets.bytes.size(), samples.bytes.size());
}

TEST(Wavelets, OfD4StarKeepTheErrorOfTheirSites) {
  const TestDevice device;
  const Source s = source_of({40, 36, 30, 16}, BCCSPLAT_TYPE_F32, [](double x, double y, double z, double t) {
    return 500 + 400 * std::sin(.2 * x + .1 * y - .2 * t) * std::cos(.15 * z);
  });
  Asked a;
  a.options.lattice = BCCSPLAT_LATTICE_D4STAR, a.channel.range[0] = 0, a.channel.range[1] = 1000;
  constexpr double allowed = 3;
  a.options.wavelet_errors = &allowed;
  const Written w = write_frames(device, s, a.options, a.channel);
  ASSERT_EQ(w.status, BCCSPLAT_OK) << w.text;
  EXPECT_LT(w.error.rmse, 4);
  EXPECT_GT(w.error.rmse, .5);
}

TEST(Wavelets, LevelsAndMovingPicturesReadThem) {
  const TestDevice device;
  const Source s = waves_in_time();
  Asked a;
  a.options.psnr = 50, a.options.levels = 1;
  const Written w = write_frames(device, s, a.options, a.channel);
  ASSERT_EQ(w.status, BCCSPLAT_OK) << w.text;
  const OpenVolume volume(device, w.bytes);
  auto at_level = sized<bccsplat_slice_options>();
  at_level.level = 1;
  const Cut coarse(volume, {0, 0, 0, 1, -7.5}, at_level), fine(volume, {0, 0, 0, 1, -7.5});
  auto level = sized<bccsplat_level_info>();
  ASSERT_EQ(bccsplat_volume_get_level_info(volume.volume, 1, &level), BCCSPLAT_OK);
  EXPECT_GT(level.scales[0], 1.9);
  EXPECT_NE(coarse.samples(), fine.samples());
  double most = 0;
  for (const float v : fine.samples()) most = larger(most, std::fabs(static_cast<double>(v)));
  EXPECT_GT(most, 700);
  const Cut across(volume, {1, 0, 0, 0, -12});
  EXPECT_EQ(across.samples().size(), size_t{30} * 25 * 20);
}

TEST(Wavelets, WhatTheyCannotHoldIsRefused) {
  const TestDevice device;
  const Source s = source_of({9, 9, 9, 4}, BCCSPLAT_TYPE_F32, moving_waves);
  const auto refused = [&](const Asked& a, const char* words) {
    const Written w = write_frames(device, s, a.options, a.channel);
    EXPECT_EQ(w.status, BCCSPLAT_ERROR_INVALID_ARGUMENT);
    EXPECT_NE(w.text.find(words), std::string::npos) << w.text;
  };
  Asked floats;
  constexpr double one = 1, below = -1;
  floats.options.wavelet_errors = &one, floats.channel.value_type = BCCSPLAT_TYPE_F32;
  floats.channel.set_mask = 0;
  refused(floats, "U8 or U16");
  refused(Asked{}, "wavelet_error");
  Asked negative;
  negative.options.wavelet_errors = &below;
  refused(negative, "wavelet_error");
}

} // namespace
} // namespace bccsplat::test
