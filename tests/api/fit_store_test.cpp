// SPDX-License-Identifier: Apache-2.0
// Other ways into a file: a host's field, and layers.
#include <random>

#include "fit_writer.h"

namespace bccsplat::test {
namespace {

double moving_wave(double x, double y, double z, double t) {
  return 3 + std::sin(0.5 * x + 0.3 * y) * std::cos(0.4 * z - 0.5 * t) + 0.2 * std::sin(0.9 * y + 0.6 * t);
}

int32_t ask_wave(void* user, uint64_t n, const double* xyzt, float* values) {
  for (uint64_t i = 0; i < n; ++i)
    values[i] =
        static_cast<float>(moving_wave(xyzt[4 * i], xyzt[4 * i + 1], xyzt[4 * i + 2], xyzt[4 * i + 3]));
  if (user && (*static_cast<int*>(user))-- <= 0) return 1;
  return 0;
}

std::vector<std::array<double, 4>> random_points(const Source& s, int n) {
  std::mt19937 random(11);
  std::vector<std::array<double, 4>> points;
  for (int i = 0; i < n; ++i) {
    std::array<double, 4> p{};
    for (size_t k = 0; k < 4; ++k) p[k] = std::uniform_real_distribution<double>(0, s.dims[k] - 1.0)(random);
    points.push_back(p);
  }
  return points;
}

double rms_error(const OpenVolume& volume, const std::vector<std::array<double, 4>>& points) {
  const auto values = volume.at(points);
  double sum = 0;
  for (size_t i = 0; i < points.size(); ++i)
    sum +=
        std::pow(double(values[i]) - moving_wave(points[i][0], points[i][1], points[i][2], points[i][3]), 2);
  return std::sqrt(sum / double(points.size()));
}

TEST(Field, IsWhatItsLayersAre) {
  const TestDevice device;
  const Source s = source_of({20, 18, 16, 14}, BCCSPLAT_TYPE_F32, moving_wave);
  const auto options = sized<bccsplat_writer_options>();
  const auto channel = sized<bccsplat_channel_options>();
  const Written field = write_with(device, s, options, channel, [&](bccsplat_writer* w) {
    return bccsplat_writer_add_field(w, 0, ask_wave, nullptr);
  });
  ASSERT_EQ(field.status, BCCSPLAT_OK) << field.text;
  const Written layers = write_with(device, s, options, channel, [&](bccsplat_writer* w) -> bccsplat_status {
    auto g = sized<bccsplat_layer_geometry>();
    for (int64_t m = 0, count = 1; m < count; ++m) {
      if (bccsplat_writer_get_layer_geometry(w, m, &g) != BCCSPLAT_OK) return BCCSPLAT_ERROR_INTERNAL;
      count = g.layer_count;
      std::vector<float> values;
      for (int64_t k = 0; k < g.dims[2]; ++k)
        for (int64_t j = 0; j < g.dims[1]; ++j)
          for (int64_t i = 0; i < g.dims[0]; ++i)
            values.push_back(static_cast<float>(moving_wave(g.origin[0] + g.step[0] * double(i),
                                                            g.origin[1] + g.step[1] * double(j),
                                                            g.origin[2] + g.step[2] * double(k), g.frame)));
      const bccsplat_status status = bccsplat_writer_add_layer(w, 0, m, values.data(), values.size());
      if (status != BCCSPLAT_OK) return status;
    }
    return BCCSPLAT_OK;
  });
  ASSERT_EQ(layers.status, BCCSPLAT_OK) << layers.text;
  EXPECT_EQ(field.bytes, layers.bytes);
  EXPECT_LT(field.report.sites_total, s.values.size() * 6 / 10);
}

// Half the samples, taken by the field itself: at least as good as resampled frames.
TEST(Field, NeedsNoResampling) {
  const TestDevice device;
  const Source s = source_of({20, 18, 16, 14}, BCCSPLAT_TYPE_F32, moving_wave);
  auto options = sized<bccsplat_writer_options>();
  const Written field =
      write_with(device, s, options, sized<bccsplat_channel_options>(),
                 [&](bccsplat_writer* w) { return bccsplat_writer_add_field(w, 0, ask_wave, nullptr); });
  const Written frames = write_frames(device, s, options);
  const OpenVolume a(device, field.bytes), b(device, frames.bytes);
  const auto points = random_points(s, 2000);
  EXPECT_LT(rms_error(a, points), rms_error(b, points));
  EXPECT_LT(rms_error(a, points), 0.02); // of values 1.8 to 4.2
}

TEST(Field, KeepsABoundAtTheSourceSamples) {
  const TestDevice device;
  for (const uint32_t frames : {1u, 7u}) {
    const Source s = source_of({12, 11, 10, frames}, BCCSPLAT_TYPE_F32, moving_wave);
    auto options = sized<bccsplat_writer_options>();
    options.abs_error = 1e-3;
    const Written w =
        write_with(device, s, options, sized<bccsplat_channel_options>(), [&](bccsplat_writer* writer) {
          return bccsplat_writer_add_field(writer, 0, ask_wave, nullptr);
        });
    ASSERT_EQ(w.status, BCCSPLAT_OK) << w.text;
    const LargestError e = largest_error(OpenVolume(device, w.bytes), s);
    EXPECT_LE(e.slices, 1e-3);
    EXPECT_LE(e.points, 1e-3);
  }
}

// The waves, missing in a corner of x and y.
bool is_missing(double x, double y) { return x + 0.7 * y < 6.2; }

int32_t ask_wave_with_holes(void* user, uint64_t n, const double* xyzt, float* values) {
  const int32_t status = ask_wave(user, n, xyzt, values);
  for (uint64_t i = 0; i < n; ++i)
    if (is_missing(xyzt[4 * i], xyzt[4 * i + 1])) values[i] = NAN;
  return status;
}

// Sites that are missing are holes of the lattice, and reach samples that are data: these have values of
// their own where a bound is promised.
TEST(Field, KeepsABoundBesideItsHoles) {
  const TestDevice device;
  const Source s = source_of({12, 11, 10, 7}, BCCSPLAT_TYPE_F32, moving_wave);
  const auto write = [&](double bound) {
    auto options = sized<bccsplat_writer_options>();
    options.nonfinite = BCCSPLAT_NONFINITE_HOLE, options.abs_error = bound;
    options.measure = BCCSPLAT_MEASURE_ALL;
    return write_with(device, s, options, sized<bccsplat_channel_options>(), [](bccsplat_writer* writer) {
      return bccsplat_writer_add_field(writer, 0, ask_wave_with_holes, nullptr);
    });
  };
  const Written loose = write(0), bounded = write(1e-2);
  ASSERT_EQ(loose.status, BCCSPLAT_OK) << loose.text;
  ASSERT_EQ(bounded.status, BCCSPLAT_OK) << bounded.text;
  EXPECT_GT(loose.error.lost, 0u);
  EXPECT_EQ(bounded.error.lost, 0u);
  const OpenVolume volume(device, bounded.bytes);
  for (uint32_t t = 0; t < s.dims[3]; ++t) {
    const std::vector<float> values = volume.frame(t);
    size_t i = 0;
    for (uint32_t z = 0; z < s.dims[2]; ++z)
      for (uint32_t y = 0; y < s.dims[1]; ++y)
        for (uint32_t x = 0; x < s.dims[0]; ++x, ++i)
          if (!is_missing(x, y)) {
            ASSERT_NEAR(values[i], moving_wave(x, y, z, t), 1e-2) << x << " " << y << " " << z << " " << t;
          }
  }
}

TEST(Field, MayGiveUpAndCannotBeMixed) {
  const TestDevice device;
  const Source s = source_of({12, 11, 10, 5}, BCCSPLAT_TYPE_F32, moving_wave);
  int calls = 3;
  const Written given_up =
      write_with(device, s, sized<bccsplat_writer_options>(), sized<bccsplat_channel_options>(),
                 [&](bccsplat_writer* w) { return bccsplat_writer_add_field(w, 0, ask_wave, &calls); });
  EXPECT_EQ(given_up.status, BCCSPLAT_CANCELLED);
  const Written mixed =
      write_with(device, s, sized<bccsplat_writer_options>(), sized<bccsplat_channel_options>(),
                 [&](bccsplat_writer* w) {
                   const bccsplat_status status = feed_frames(s, w);
                   return status ? status : bccsplat_writer_add_field(w, 0, ask_wave, nullptr);
                 });
  EXPECT_EQ(mixed.status, BCCSPLAT_ERROR_WRONG_STATE);
}

} // namespace
} // namespace bccsplat::test
