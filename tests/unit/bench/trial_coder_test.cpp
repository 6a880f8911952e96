// SPDX-License-Identifier: Apache-2.0
// The trial of a third store: what comes back of its bytes, and what becomes of damaged ones.
#include "tests/bench/coder/trial_coder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "base/error.h"
#include "tests/bench/coder/wavelet.h"

namespace bccsplat::bench {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

// A moving ball with noise in it, in air that is exactly 0; axes of uneven lengths.
TrialSeries moving_ball() {
  TrialSeries s{{37, 22, 13, 9}, {}};
  std::mt19937 random(3);
  std::normal_distribution<float> noise(0, .01F);
  for (int t = 0; t < s.dims[3]; ++t)
    for (int z = 0; z < s.dims[2]; ++z)
      for (int y = 0; y < s.dims[1]; ++y)
        for (int x = 0; x < s.dims[0]; ++x) {
          const double r = std::hypot(x - 10 - t, y - 9, z - 5);
          s.values.push_back(r < 7 ? static_cast<float>(1 + std::cos(r / 3)) + noise(random) : 0.0F);
        }
  return s;
}

double psnr(const TrialSeries& a, const TrialSeries& b) {
  const auto [low, high] = std::minmax_element(a.values.begin(), a.values.end());
  double squares = 0;
  for (size_t i = 0; i < a.values.size(); ++i) squares += std::pow(double{a.values[i]} - b.values[i], 2);
  return 20 * std::log10((*high - *low) / std::sqrt(squares / static_cast<double>(a.values.size())));
}

TEST(TrialCoder, KeepsThePsnrThatIsAskedFor) {
  const TrialSeries series = moving_ball();
  size_t before = 0;
  for (const double goal : {35.0, 45.0, 60.0}) {
    TrialOptions options;
    options.psnr = goal;
    const TrialFile file = trial_encode(series, options);
    const TrialSeries back = trial_decode(file.bytes);
    ASSERT_EQ(back.dims, series.dims);
    EXPECT_GE(psnr(series, back), goal - 1e-3);
    EXPECT_LE(psnr(series, back), goal + 1) << "it takes more bytes than it has to";
    EXPECT_GT(file.bytes.size(), before);
    EXPECT_LT(file.bytes.size(), series.values.size());
    before = file.bytes.size();
  }
}

TEST(TrialCoder, KeepsABoundOfEverySample) {
  const TrialSeries series = moving_ball();
  for (const float bound : {.1F, .004F}) {
    TrialOptions options;
    options.bound = bound;
    const TrialFile file = trial_encode(series, options);
    EXPECT_GT(file.details, 0U);
    const TrialSeries back = trial_decode(file.bytes);
    for (size_t i = 0; i < series.values.size(); ++i)
      ASSERT_LE(std::fabs(back.values[i] - series.values[i]), bound * 1.0001F) << i;
  }
}

TEST(TrialCoder, HolesAreHolesAndAirIsAir) {
  TrialSeries series = moving_ball();
  for (size_t i = 5000; i < 5400; ++i) series.values[i] = nan;
  TrialOptions options;
  options.bound = .05;
  const TrialSeries back = trial_decode(trial_encode(series, options).bytes);
  for (size_t i = 0; i < series.values.size(); ++i)
    ASSERT_EQ(std::isnan(back.values[i]), std::isnan(series.values[i])) << i;
  const size_t corner = series.values.size() - 1; // of a block that is air in all frames
  EXPECT_EQ(back.values[corner], 0.0F);
  series.values.assign(series.values.size(), nan);
  EXPECT_THROW((void)trial_encode(series, options), Error);
}

TEST(TrialCoder, ConstantsAndSingleSamplesComeBack) {
  for (const std::array<int, 4>& dims : {std::array<int, 4>{1, 1, 1, 1}, {9, 1, 5, 2}, {16, 16, 16, 1}}) {
    TrialSeries series{dims, {}};
    series.values.assign(size_t(dims[0]) * dims[1] * dims[2] * dims[3], 7.5F);
    EXPECT_EQ(trial_decode(trial_encode(series, {}).bytes).values, series.values);
  }
}

TEST(TrialCoder, AMomentReadsItsSlabsOnly) {
  const TrialSeries series = moving_ball();
  TrialOptions options;
  options.slab = 3, options.edge = 16;
  const TrialFile file = trial_encode(series, options);
  const uint64_t one = trial_moment_bytes(file.bytes, 3, 5), two = trial_moment_bytes(file.bytes, 2, 5);
  EXPECT_LT(one, two);
  EXPECT_LT(two, file.bytes.size());
  EXPECT_EQ(trial_moment_bytes(file.bytes, 0, 8), file.bytes.size());
  EXPECT_GE(psnr(series, trial_decode(file.bytes)), options.psnr - 1e-3);
  options.edge = 12;
  EXPECT_THROW((void)trial_encode(series, options), Error);
}

// A part of what follows is decoded, or refused; either way nothing breaks.
void expect_decoded_or_refused(std::span<const std::byte> bytes) {
  try {
    const TrialSeries back = trial_decode(bytes);
    EXPECT_FALSE(back.values.empty());
  } catch (const Error&) {
  }
}

TEST(TrialCoder, DamagedBytesDoNoHarm) {
  TrialSeries series = moving_ball();
  series.values[700] = nan;
  TrialOptions options;
  options.slab = 5, options.bound = .05;
  const std::vector<std::byte> whole = trial_encode(series, options).bytes;
  EXPECT_THROW((void)trial_decode(std::span(whole).first(3)), Error);
  EXPECT_THROW((void)trial_decode(std::span(whole).first(whole.size() - 1)), Error);
  std::mt19937 random(8);
  for (int i = 0; i < 60; ++i) {
    std::vector<std::byte> damaged = whole;
    const size_t at = i < 30 ? 8 + static_cast<size_t>(i) * 3 : random() % damaged.size();
    damaged[at] ^= static_cast<std::byte>(1U << random() % 8);
    expect_decoded_or_refused(damaged);
    damaged.resize(at);
    expect_decoded_or_refused(damaged);
  }
}

TEST(TrialCoder, TheChainIsUndone) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> value(-1, 1);
  for (const std::array<int, 3>& size : {std::array<int, 3>{1, 2, 3}, {17, 8, 5}, {70, 6, 9}}) {
    const Chain chain{size, {3, 2, 1}};
    std::vector<float> frame(chain.samples());
    for (float& v : frame) v = value(random);
    std::vector<float> back = frame;
    analyse(chain, back);
    synthesise(chain, back);
    for (size_t i = 0; i < frame.size(); ++i) ASSERT_NEAR(back[i], frame[i], 1e-5F) << i;
  }
}

} // namespace
} // namespace bccsplat::bench
