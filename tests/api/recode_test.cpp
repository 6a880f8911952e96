// SPDX-License-Identifier: Apache-2.0
// Files written anew without their source.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "fit_writer.h"

namespace bccsplat::test {
namespace {

double raised_wave(double x, double y, double z, double t) {
  return 120 + 50 * std::sin(0.5 * x + 0.3 * y) * std::cos(0.4 * z - 0.5 * t) +
         10 * std::sin(0.9 * y + 0.6 * t);
}

class Recode : public testing::Test {
 protected:
  ~Recode() override { std::filesystem::remove(path); }

  // The bytes of `file` written anew.
  Bytes recoded(const Bytes& file, bccsplat_recode_options options, bccsplat_status expected = BCCSPLAT_OK) {
    const OpenVolume volume(device, file);
    options.overwrite = 1;
    EXPECT_EQ(bccsplat_volume_recode(volume.volume, path.c_str(), &options, nullptr), expected)
        << bccsplat_last_error();
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  double difference(const Bytes& a, const Bytes& b) const {
    const auto x = OpenVolume(device, a).frame(5.25), y = OpenVolume(device, b).frame(5.25);
    double squares = 0;
    for (size_t i = 0; i < x.size(); ++i)
      if (std::isnan(x[i]) != std::isnan(y[i]))
        ADD_FAILURE() << "hole at " << i;
      else if (!std::isnan(x[i]))
        squares += std::pow(x[i] - y[i], 2);
    return std::sqrt(squares / static_cast<double>(x.size()));
  }

  const TestDevice device;
  const Source bytes = source_of({22, 18, 16, 11}, BCCSPLAT_TYPE_U8, raised_wave);
  const std::string path =
      (std::filesystem::temp_directory_path() / ("recode_" + std::to_string(getpid()) + ".bcc4")).string();
};

// From samples to coefficients and back, by steps of the same value, the field changes by less than a step.
TEST_F(Recode, SamplesAndCoefficients) {
  auto written = sized<bccsplat_writer_options>();
  written.nonfinite = BCCSPLAT_NONFINITE_HOLE;
  const Bytes samples = write_frames(device, bytes, written).bytes;
  auto options = sized<bccsplat_recode_options>();
  // What is asked to stay as it is stays so, byte for byte.
  EXPECT_EQ(recoded(samples, options), samples);
  options.store = BCCSPLAT_STORE_COEFFICIENTS;
  const Bytes coefficients = recoded(samples, options);
  EXPECT_EQ(coefficients[14], 3);
  EXPECT_LT(difference(samples, coefficients), 0.4);
  EXPECT_EQ(recoded(coefficients, sized<bccsplat_recode_options>()), coefficients);
  options.store = BCCSPLAT_STORE_SAMPLES;
  const Bytes back = recoded(coefficients, options);
  EXPECT_LT(back[14], 3);
  EXPECT_LT(difference(samples, back), 0.6);
  // An import that stores coefficients does not round the samples first, and is no further from them.
  written.store = BCCSPLAT_STORE_COEFFICIENTS;
  EXPECT_LT(difference(write_frames(device, bytes, written).bytes, coefficients), 0.5);
}

TEST_F(Recode, StepsKernelsAndTypes) {
  auto written = sized<bccsplat_writer_options>();
  written.store = BCCSPLAT_STORE_COEFFICIENTS;
  const Bytes file = write_frames(device, bytes, written).bytes;
  auto coarse = sized<bccsplat_recode_options>();
  coarse.value_step = 4;
  const Bytes rough = recoded(file, coarse);
  EXPECT_LT(rough.size(), file.size());
  const double error = difference(file, rough);
  EXPECT_GT(error, 0.3);
  EXPECT_LT(error, 1.6);
  auto other = sized<bccsplat_recode_options>();
  other.kernel = "fine";
  const Bytes fine = recoded(file, other);
  auto info = sized<bccsplat_volume_info>();
  const OpenVolume volume(device, fine);
  ASSERT_EQ(bccsplat_volume_get_info(volume.volume, &info), BCCSPLAT_OK);
  EXPECT_STREQ(info.kernel, "radial24+b4");
  EXPECT_LT(difference(file, fine), 0.6);
  auto floats = sized<bccsplat_recode_options>();
  floats.value_type = BCCSPLAT_TYPE_F32, floats.format = 2;
  const Bytes exact = recoded(file, floats);
  EXPECT_LT(exact[14], 3);
  EXPECT_EQ(difference(file, exact), 0);
}

TEST_F(Recode, LeavesOutWhatBelongsToTheOldNumbers) {
  auto written = sized<bccsplat_writer_options>();
  written.abs_error = 0.75;
  const Written bounded = write_frames(device, bytes, written);
  ASSERT_EQ(bounded.status, BCCSPLAT_OK) << bounded.text;
  EXPECT_GT(bounded.report.corrected, 0u);
  const Bytes file = recoded(bounded.bytes, sized<bccsplat_recode_options>());
  const OpenVolume volume(device, file);
  auto channel = sized<bccsplat_channel_info>();
  ASSERT_EQ(bccsplat_volume_get_channel_info(volume.volume, 0, &channel), BCCSPLAT_OK);
  EXPECT_EQ(channel.error_bound, 0);
}

// What is clamped is counted, and what an earlier writer clamped stays counted where the numbers stay.
TEST_F(Recode, CountsWhatIsClamped) {
  const Source steep = source_of({22, 18, 16, 11}, BCCSPLAT_TYPE_U8, [](double x, double, double z, double) {
    return x > 7 && x < 15 && z > 5 ? 255 : 0;
  });
  const Written written = write_frames(device, steep, sized<bccsplat_writer_options>());
  EXPECT_GT(written.report.clamped, 0u);
  EXPECT_EQ(recoded(written.bytes, sized<bccsplat_recode_options>()), written.bytes);
  auto coefficients = sized<bccsplat_writer_options>();
  coefficients.store = BCCSPLAT_STORE_COEFFICIENTS;
  const Bytes file = write_frames(device, steep, coefficients).bytes;
  const OpenVolume volume(device, file);
  auto options = sized<bccsplat_recode_options>();
  auto report = sized<bccsplat_writer_report>();
  options.overwrite = 1, options.store = BCCSPLAT_STORE_SAMPLES;
  ASSERT_EQ(bccsplat_volume_recode(volume.volume, path.c_str(), &options, &report), BCCSPLAT_OK);
  EXPECT_GT(report.clamped, written.report.clamped / 2);
}

TEST_F(Recode, RefusesStepsThatDoNotFit) {
  const Bytes file = write_frames(device, bytes, sized<bccsplat_writer_options>()).bytes;
  auto options = sized<bccsplat_recode_options>();
  options.store = BCCSPLAT_STORE_COEFFICIENTS, options.value_step = 1e-7;
  (void)recoded(file, options, BCCSPLAT_ERROR_INVALID_ARGUMENT);
  options.value_step = 50, options.value_type = BCCSPLAT_TYPE_F32;
  (void)recoded(file, options, BCCSPLAT_ERROR_INVALID_ARGUMENT);
}

// Halves that are stored as they are, not relative to air, stay so.
TEST_F(Recode, KeepsHalvesOfTheSource) {
  Source s = source_of({14, 12, 10, 9}, BCCSPLAT_TYPE_F32,
                       [](double x, double y, double z, double t) { return raised_wave(x, y, z, t) / 300; });
  s.air = 0.3;
  auto channel = sized<bccsplat_channel_options>();
  channel.source_type = BCCSPLAT_TYPE_F16;
  const Bytes file = write_frames(device, s, sized<bccsplat_writer_options>(), channel).bytes;
  EXPECT_EQ(recoded(file, sized<bccsplat_recode_options>()), file);
}

TEST_F(Recode, RefusesParts) {
  auto written = sized<bccsplat_writer_options>();
  auto part = sized<bccsplat_series_part>();
  std::vector<double> times;
  for (uint32_t t = 0; t < bytes.dims[3]; ++t) times.push_back(t);
  part.end = bytes.dims[3], part.times = times.data();
  written.part = &part;
  const Written w = write_frames(device, bytes, written);
  ASSERT_EQ(w.status, BCCSPLAT_OK) << w.text;
  (void)recoded(w.bytes, sized<bccsplat_recode_options>(), BCCSPLAT_ERROR_UNSUPPORTED);
}

} // namespace
} // namespace bccsplat::test
