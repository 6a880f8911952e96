// SPDX-License-Identifier: Apache-2.0
// The faces of a field: what a writer stores outside them, and how true the field is beside them.
#include <algorithm>
#include <random>

#include "fit_writer.h"

namespace bccsplat::test {
namespace {

// A plane wave of 0.4 of the frequencies that the lattice holds, askew to all faces.
double askew_wave(double x, double y, double z, double t) {
  return std::sin(.9 * x - .6 * y + .45 * z + .4 * t + 1);
}

int32_t ask_askew_wave(void*, uint64_t n, const double* p, float* values) {
  for (uint64_t i = 0; i < n; ++i, p += 4) values[i] = static_cast<float>(askew_wave(p[0], p[1], p[2], p[3]));
  return 0;
}

bccsplat_volume_info info_of(const OpenVolume& volume) {
  auto info = sized<bccsplat_volume_info>();
  EXPECT_EQ(bccsplat_volume_get_info(volume.volume, &info), BCCSPLAT_OK);
  return info;
}

struct FaceErrors {
  double value, gradient; // RMS
};
// At points within a sample of a face, in the middle frames.
FaceErrors errors_at_faces(const OpenVolume& volume, const Source& s) {
  std::mt19937 random(4);
  std::vector<double> points;
  for (int i = 0; i < 2000; ++i) {
    std::array<double, 4> p{};
    for (size_t a = 0; a < 4; ++a) p[a] = std::uniform_real_distribution<double>(0, s.dims[a] - 1.0)(random);
    if (s.dims[3] > 1) p[3] = std::uniform_real_distribution<double>(3, s.dims[3] - 4.0)(random);
    const double near = std::uniform_real_distribution<double>(0, 1)(random);
    const size_t a = random() % 3;
    p[a] = random() & 1 ? s.dims[a] - 1.0 - near : near;
    points.insert(points.end(), p.begin(), p.end());
  }
  const size_t n = points.size() / 4;
  std::vector<float> values(n), gradients(4 * n);
  EXPECT_EQ(bccsplat_volume_evaluate(volume.volume, n, points.data(), values.data(), gradients.data()),
            BCCSPLAT_OK);
  FaceErrors e{0, 0};
  for (size_t i = 0; i < n; ++i) {
    const double* p = &points[4 * i];
    e.value += std::pow(values[i] - askew_wave(p[0], p[1], p[2], p[3]), 2) / static_cast<double>(n);
    const double slope = std::cos(.9 * p[0] - .6 * p[1] + .45 * p[2] + .4 * p[3] + 1);
    e.gradient += std::pow(gradients[4 * i] - .9 * slope, 2) / static_cast<double>(n);
  }
  return {std::sqrt(e.value), std::sqrt(e.gradient)};
}

Written written(const TestDevice& device, const Source& s, int32_t faces, int32_t lattice = 0) {
  auto options = sized<bccsplat_writer_options>();
  options.faces = faces, options.lattice = lattice;
  Written w = write_frames(device, s, options);
  EXPECT_EQ(w.status, BCCSPLAT_OK) << w.text;
  return w;
}

TEST(Faces, ArePredictedByDefault) {
  const TestDevice device;
  for (const uint32_t frames : {1u, 12u}) {
    const Source s = source_of({46, 44, 48, frames}, BCCSPLAT_TYPE_F32, askew_wave);
    const Written first = written(device, s, BCCSPLAT_FACES_DEFAULT),
                  second = written(device, s, BCCSPLAT_FACES_MIRROR);
    const OpenVolume predicted(device, first.bytes), mirrored(device, second.bytes);
    const auto more = info_of(predicted), none = info_of(mirrored);
    for (int a = 0; a < 3; ++a) {
      EXPECT_EQ(more.planes_before[a], 2u);
      EXPECT_EQ(more.planes_behind[a], 2u);
      EXPECT_EQ(none.planes_before[a] + none.planes_behind[a], 0u);
    }
    const FaceErrors now = errors_at_faces(predicted, s), before = errors_at_faces(mirrored, s);
    EXPECT_LT(10 * now.value, before.value) << frames;
    EXPECT_LT(4 * now.gradient, before.gradient) << frames;
  }
}

// Unasked only where it costs a sixteenth of an axis at most, asked for a fifth; never where the samples are
// the sites.
TEST(Faces, HavePlanesWhereTheyCostLittle) {
  const TestDevice device;
  const auto planes = [&](std::array<uint32_t, 4> dims, int32_t faces, int32_t lattice = 0) {
    const Source s = source_of(dims, BCCSPLAT_TYPE_U8, [](double, double, double, double) { return 7; });
    const Written w = written(device, s, faces, lattice);
    const OpenVolume volume(device, w.bytes);
    const auto info = info_of(volume);
    return std::array<uint32_t, 3>{info.planes_before[0], info.planes_before[1], info.planes_before[2]};
  };
  using Planes = std::array<uint32_t, 3>;
  EXPECT_EQ(planes({42, 43, 1, 5}, BCCSPLAT_FACES_DEFAULT), (Planes{0, 2, 0}));
  EXPECT_EQ(planes({11, 12, 1, 5}, BCCSPLAT_FACES_PREDICT), (Planes{0, 2, 0}));
  EXPECT_EQ(planes({44, 44, 4, 5}, BCCSPLAT_FACES_DEFAULT, BCCSPLAT_LATTICE_CC), (Planes{0, 0, 0}));
  EXPECT_EQ(planes({44, 44, 4, 5}, BCCSPLAT_FACES_PREDICT, BCCSPLAT_LATTICE_CC), (Planes{2, 2, 0}));
  EXPECT_EQ(planes({43, 43, 1, 5}, BCCSPLAT_FACES_PREDICT_Y), (Planes{0, 2, 0}));
  EXPECT_EQ(planes({9, 20, 3, 5}, BCCSPLAT_FACES_PREDICT_X + BCCSPLAT_FACES_PREDICT_Z), (Planes{2, 0, 2}));
  EXPECT_EQ(planes({1, 2, 20, 5}, BCCSPLAT_FACES_PREDICT_X + BCCSPLAT_FACES_PREDICT_Y), (Planes{0, 2, 0}));
  auto options = sized<bccsplat_writer_options>();
  options.faces = 33;
  EXPECT_EQ(write_frames(device, source_of({4, 4, 4, 1}, BCCSPLAT_TYPE_U8, askew_wave), options).status,
            BCCSPLAT_ERROR_INVALID_ARGUMENT);
  options.faces = 3;
  const Source s = source_of({4, 4, 4, 1}, BCCSPLAT_TYPE_U8, askew_wave);
  EXPECT_EQ(write_frames(device, s, options).status, BCCSPLAT_ERROR_INVALID_ARGUMENT);
}

// Fields and layers hold the planes outside where a host asks for them.
TEST(Faces, OfFieldsAndLayersAreTheHosts) {
  const TestDevice device;
  const Source s = source_of({30, 28, 26, 14}, BCCSPLAT_TYPE_F32, askew_wave);
  auto options = sized<bccsplat_writer_options>();
  const auto field = [&] {
    return write_with(device, s, options, sized<bccsplat_channel_options>(), [&](bccsplat_writer* w) {
      return bccsplat_writer_add_field(w, 0, ask_askew_wave, nullptr);
    });
  };
  const Written plain = field();
  options.faces = BCCSPLAT_FACES_PREDICT;
  const Written asked = field();
  const Written layers = write_with(
      device, s, options, sized<bccsplat_channel_options>(), [](bccsplat_writer* w) -> bccsplat_status {
        auto g = sized<bccsplat_layer_geometry>();
        for (int64_t m = 0; m == 0 || m < g.layer_count; ++m) {
          bccsplat_status status = bccsplat_writer_get_layer_geometry(w, m, &g);
          if (status != BCCSPLAT_OK) return status;
          EXPECT_LT(g.origin[0], -.5); // outside
          std::vector<float> values;
          for (int64_t k = 0; k < g.dims[2]; ++k)
            for (int64_t j = 0; j < g.dims[1]; ++j)
              for (int64_t i = 0; i < g.dims[0]; ++i)
                values.push_back(static_cast<float>(
                    askew_wave(g.origin[0] + g.step[0] * static_cast<double>(i),
                               g.origin[1] + g.step[1] * static_cast<double>(j),
                               g.origin[2] + g.step[2] * static_cast<double>(k), g.frame)));
          status = bccsplat_writer_add_layer(w, 0, m, values.data(), values.size());
          if (status != BCCSPLAT_OK) return status;
        }
        return BCCSPLAT_OK;
      });
  ASSERT_EQ(asked.status, BCCSPLAT_OK) << asked.text;
  EXPECT_EQ(asked.bytes, layers.bytes);
  const OpenVolume a(device, asked.bytes), b(device, plain.bytes);
  EXPECT_EQ(info_of(b).planes_before[0], 0u);
  EXPECT_LT(20 * errors_at_faces(a, s).value, errors_at_faces(b, s).value);
}

// A cloud that touches a face leaves the air beside it as it is, and a constant stays one.
TEST(Faces, LeaveAirAndConstantsAlone) {
  const TestDevice device;
  const Source cloud = source_of({48, 48, 48, 1}, BCCSPLAT_TYPE_U8, [](double x, double y, double z, double) {
    const double r2 = x * x + std::pow(y - 24, 2) + std::pow(z - 24, 2);
    return r2 < 144 ? 200 * std::exp(-r2 / 60) : 0;
  });
  const Written with = written(device, cloud, BCCSPLAT_FACES_DEFAULT),
                without = written(device, cloud, BCCSPLAT_FACES_MIRROR);
  // Half of the disc on the face, two planes deep.
  EXPECT_LT(with.report.sites_kept, without.report.sites_kept + 1200);
  const OpenVolume volume(device, with.bytes);
  std::vector<double> points;
  for (double y = 0; y < 48; y += 1.5)
    for (double z = 0; z < 48; z += 1.5)
      if (std::hypot(y - 24, z - 24) > 16)
        for (const double x : {0.0, .4, 1.1}) points.insert(points.end(), {x, y, z, 0});
  std::vector<float> values(points.size() / 4);
  ASSERT_EQ(bccsplat_volume_evaluate(volume.volume, values.size(), points.data(), values.data(), nullptr),
            BCCSPLAT_OK);
  for (const float v : values) ASSERT_NEAR(v, 0, .3);

  const Source constant =
      source_of({48, 48, 48, 1}, BCCSPLAT_TYPE_U16, [](double, double, double, double) { return 20000; });
  const Written flat = written(device, constant, BCCSPLAT_FACES_DEFAULT);
  EXPECT_EQ(flat.report.clamped, 0u);
  const OpenVolume level(device, flat.bytes);
  auto channel = sized<bccsplat_channel_info>();
  ASSERT_EQ(bccsplat_volume_get_channel_info(level.volume, 0, &channel), BCCSPLAT_OK);
  EXPECT_EQ(channel.kept_range[0], 20000);
  EXPECT_EQ(channel.kept_range[1], 20000);
}

} // namespace
} // namespace bccsplat::test
