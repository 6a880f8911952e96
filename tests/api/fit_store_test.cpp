// SPDX-License-Identifier: Apache-2.0
// Other ways into a file: a host's field, layers, and coefficients instead of samples.
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

TEST(Coefficients, GiveTheSameFieldAsSamples) {
  const TestDevice device;
  for (const int32_t lattice : {BCCSPLAT_LATTICE_DEFAULT, BCCSPLAT_LATTICE_CC})
    for (const uint32_t frames : {1u, 12u})
      for (const char* kernel : {"default", "fast", "fine"}) {
        if (lattice == BCCSPLAT_LATTICE_CC && std::string(kernel) == "fine") continue;
        SCOPED_TRACE(std::string(kernel) + ", lattice " + std::to_string(lattice) + ", frames " +
                     std::to_string(frames));
        const Source s = source_of({20, 18, 16, frames}, BCCSPLAT_TYPE_F32, moving_wave);
        auto options = sized<bccsplat_writer_options>();
        options.recommended_kernel = kernel, options.lattice = lattice;
        const Written samples = write_frames(device, s, options);
        options.store = BCCSPLAT_STORE_COEFFICIENTS;
        options.measure = BCCSPLAT_MEASURE_ALL;
        const Written stored = write_frames(device, s, options);
        ASSERT_EQ(stored.status, BCCSPLAT_OK) << stored.text;
        const OpenVolume a(device, samples.bytes), b(device, stored.bytes);
        ASSERT_EQ(b.status, BCCSPLAT_OK) << bccsplat_last_error();
        const auto points = random_points(s, 500);
        EXPECT_EQ(a.at(points), b.at(points)); // f32: to the last bit
        EXPECT_EQ(stored.error.max_abs, largest_error(b, s).slices);
        auto info = sized<bccsplat_volume_info>();
        ASSERT_EQ(bccsplat_volume_get_info(b.volume, &info), BCCSPLAT_OK);
        EXPECT_EQ(info.store, BCCSPLAT_STORE_COEFFICIENTS);
        auto channel = sized<bccsplat_channel_options>();
        channel.value_type = BCCSPLAT_TYPE_F16;
        const Written half = write_frames(device, s, options, channel);
        const auto exact = a.at(points), rounded = OpenVolume(device, half.bytes).at(points);
        for (size_t i = 0; i < points.size(); ++i) EXPECT_NEAR(exact[i], rounded[i], 8 * 4.2 * 0x1p-11);
        EXPECT_LT(half.bytes.size(), stored.bytes.size());
      }
}

TEST(Coefficients, KnowTheirKernelAndReadFewerLayers) {
  const TestDevice device;
  const Source s = source_of({34, 30, 28, 40}, BCCSPLAT_TYPE_F32, moving_wave);
  auto options = sized<bccsplat_writer_options>();
  const Written samples = write_frames(device, s, options);
  options.store = BCCSPLAT_STORE_COEFFICIENTS;
  const Written stored = write_frames(device, s, options);
  const auto read = [&](const Written& w) {
    const OpenVolume volume(device, w.bytes);
    (void)volume.frame(20);
    auto info = sized<bccsplat_volume_info>();
    EXPECT_EQ(bccsplat_volume_get_info(volume.volume, &info), BCCSPLAT_OK);
    return static_cast<double>(info.bytes_read) / static_cast<double>(info.bytes_file);
  };
  EXPECT_LT(read(stored), 0.7 * read(samples));
}

// What another kernel or a slice across another axis sees of stored coefficients are the samples they give.
TEST(Coefficients, OtherKernelsAndAxesSeeTheirSamples) {
  const TestDevice device;
  const Source s = source_of({34, 30, 28, 24}, BCCSPLAT_TYPE_U8, [](double x, double y, double z, double t) {
    return 50 * moving_wave(x, y, z, t);
  });
  auto options = sized<bccsplat_writer_options>();
  const Written samples = write_frames(device, s, options);
  options.store = BCCSPLAT_STORE_COEFFICIENTS;
  const Written stored = write_frames(device, s, options);
  ASSERT_EQ(stored.status, BCCSPLAT_OK) << stored.text;
  const auto points = random_points(s, 2000);
  for (const char* kernel : {"fast", "fine", "radial18+b3", "paper"}) {
    const auto a = OpenVolume(device, samples.bytes, kernel).at(points),
               b = OpenVolume(device, stored.bytes, kernel).at(points);
    double squares = 0;
    for (size_t i = 0; i < points.size(); ++i) squares += std::pow(a[i] - b[i], 2);
    EXPECT_LT(std::sqrt(squares / double(points.size())), 0.5)
        << kernel; // of values 90 to 210, in steps of 1
  }
  auto across = sized<bccsplat_slice_options>();
  across.method = BCCSPLAT_METHOD_MERGED;
  auto plane = sized<bccsplat_hyperplane>();
  plane.a = 1, plane.e = -17.25;
  std::vector<std::vector<float>> cuts;
  for (const Written* w : {&samples, &stored}) {
    const OpenVolume volume(device, w->bytes);
    bccsplat_slice* slice = nullptr;
    ASSERT_EQ(bccsplat_slice_create(volume.volume, &plane, &across, &slice), BCCSPLAT_OK)
        << bccsplat_last_error();
    auto info = sized<bccsplat_slice_info>();
    ASSERT_EQ(bccsplat_slice_get_info(slice, &info), BCCSPLAT_OK);
    cuts.emplace_back(info.dims[0] * info.dims[1] * info.dims[2]);
    ASSERT_EQ(bccsplat_slice_sample_grid(slice, nullptr, cuts.back().data()), BCCSPLAT_OK);
    bccsplat_slice_release(slice);
  }
  ASSERT_EQ(cuts[0].size(), cuts[1].size());
  double squares = 0;
  for (size_t i = 0; i < cuts[0].size(); ++i) squares += std::pow(cuts[0][i] - cuts[1][i], 2);
  EXPECT_LT(std::sqrt(squares / double(cuts[0].size())), 0.5);
}

// Sources of integers: whole steps from air, at the error of files of samples.
TEST(Coefficients, OfIntegersAreSteps) {
  const TestDevice device;
  for (const int32_t lattice : {BCCSPLAT_LATTICE_DEFAULT, BCCSPLAT_LATTICE_CC})
    for (const uint32_t frames : {1u, 14u})
      for (const int32_t type : {BCCSPLAT_TYPE_U8, BCCSPLAT_TYPE_I16}) {
        SCOPED_TRACE("type " + std::to_string(type) + ", lattice " + std::to_string(lattice) + ", frames " +
                     std::to_string(frames));
        Source s = source_of({20, 18, 16, frames}, type, [&](double x, double y, double z, double t) {
          return (type == BCCSPLAT_TYPE_I16 ? -2000 : 0) + 60 * moving_wave(x, y, z, t);
        });
        s.air = type == BCCSPLAT_TYPE_I16 ? -1900 : 0;
        auto options = sized<bccsplat_writer_options>();
        options.lattice = lattice;
        options.measure = BCCSPLAT_MEASURE_ALL;
        options.recommended_kernel = "default"; // that of coefficients; samples on CC would have kernel exact
        const Written samples = write_frames(device, s, options);
        options.store = BCCSPLAT_STORE_COEFFICIENTS;
        const Written stored = write_frames(device, s, options);
        ASSERT_EQ(stored.status, BCCSPLAT_OK) << stored.text;
        const OpenVolume volume(device, stored.bytes);
        ASSERT_EQ(volume.status, BCCSPLAT_OK) << bccsplat_last_error();
        auto info = sized<bccsplat_channel_info>();
        ASSERT_EQ(bccsplat_volume_get_channel_info(volume.volume, 0, &info), BCCSPLAT_OK);
        EXPECT_EQ(info.value_type, BCCSPLAT_TYPE_I32);
        EXPECT_EQ(stored.bytes[14], 3); // lowest version of the format
        EXPECT_LT(samples.bytes[14], 3);
        // What was measured while writing is what a reader gets.
        const LargestError e = largest_error(volume, s);
        EXPECT_EQ(stored.error.max_abs, e.slices);
        // What steps add is no more than rounding to those of the source, of which files of samples may have
        // some.
        EXPECT_LT(stored.error.rmse, std::hypot(samples.error.rmse, 0.3));
        EXPECT_EQ(stored.report.clamped, 0u);
      }
}

TEST(Coefficients, KeepHolesAndBounds) {
  const TestDevice device;
  const Source s = source_of({14, 13, 12, 9}, BCCSPLAT_TYPE_F32, [](double x, double y, double z, double t) {
    return x >= 5 && x < 9 && y > 6 && z > 3 ? std::numeric_limits<double>::quiet_NaN()
                                             : moving_wave(x, y, z, t);
  });
  auto options = sized<bccsplat_writer_options>();
  options.nonfinite = BCCSPLAT_NONFINITE_HOLE;
  const Written samples = write_frames(device, s, options);
  options.store = BCCSPLAT_STORE_COEFFICIENTS;
  const Written stored = write_frames(device, s, options);
  ASSERT_EQ(stored.status, BCCSPLAT_OK) << stored.text;
  const auto points = random_points(s, 500);
  const auto a = OpenVolume(device, samples.bytes).at(points),
             b = OpenVolume(device, stored.bytes).at(points);
  size_t holes = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(std::isnan(a[i]), std::isnan(b[i]));
    holes += std::isnan(a[i]);
    if (!std::isnan(a[i])) {
      EXPECT_EQ(a[i], b[i]);
    }
  }
  EXPECT_GT(holes, 10u);
  options.abs_error = 0.01;
  auto channel = sized<bccsplat_channel_options>();
  channel.value_type = BCCSPLAT_TYPE_F16;
  const Written bounded = write_frames(device, s, options, channel);
  ASSERT_EQ(bounded.status, BCCSPLAT_OK) << bounded.text;
  const LargestError e = largest_error(OpenVolume(device, bounded.bytes), s);
  EXPECT_LE(e.slices, 0.01);
  EXPECT_LE(e.points, 0.01);
}

TEST(Coefficients, RefuseWhatCannotHoldThem) {
  const TestDevice device;
  Source s = source_of({9, 8, 7, 5}, BCCSPLAT_TYPE_F32, moving_wave);
  auto options = sized<bccsplat_writer_options>();
  options.store = BCCSPLAT_STORE_COEFFICIENTS;
  auto channel = sized<bccsplat_channel_options>();
  channel.value_type = BCCSPLAT_TYPE_U8; // floats in steps need a range
  EXPECT_EQ(write_frames(device, s, options, channel).status, BCCSPLAT_ERROR_INVALID_ARGUMENT);
  channel.set_mask = BCCSPLAT_CHANNEL_SET_RANGE, channel.range[1] = 5;
  EXPECT_EQ(write_frames(device, s, options, channel).status, BCCSPLAT_OK);
  options.recommended_kernel = "paper";
  EXPECT_EQ(write_frames(device, s, options).status, BCCSPLAT_ERROR_UNSUPPORTED);
  options.recommended_kernel = nullptr;
  s.dims[3] = 0;
  EXPECT_EQ(write_frames(device, s, options).status, BCCSPLAT_ERROR_INVALID_ARGUMENT);
}

} // namespace
} // namespace bccsplat::test
