// SPDX-License-Identifier: Apache-2.0
// Values at single points: what rounding puts beside a face, the world instead of indices, and what is read.
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "support.h"

using namespace host;

namespace {

using Vec4 = std::array<double, 4>;

// An oblique box in mm, uneven times.
class Probes : public testing::Test {
 protected:
  static constexpr uint64_t n = 96, frames = 5;
  static constexpr std::array<double, frames> times{10, 10.5, 12, 12.25, 14};
  Probes() {
    series_.nx = series_.ny = series_.nz = n, series_.nt = frames;
    series_.times.assign(times.begin(), times.end());
    series_.field = [](double x, double y, double z, double t) {
      return 50 + 20 * std::sin(0.11 * x + 0.07 * y) + 0.2 * z + 3 * std::cos(0.5 * t);
    };
    auto o = options_of(series_);
    const double c = 0.8, s = 0.6, pitch = 0.7; // turned about z
    const double rows[16] = {c * pitch, -s * pitch, 0,   -31.4, s * pitch, c * pitch, 0, 12.7,
                             0,         0,          2.5, 3.3,   0,         0,         0, 1};
    std::copy(std::begin(rows), std::end(rows), o.affine),
        std::copy(std::begin(rows), std::end(rows), affine_);
    const Writer w = make_writer(device_, folder_.file("p.bcc4"), o);
    EXPECT_OK(add_frames(w.get(), series_));
    EXPECT_OK(bccsplat_writer_finish(w.get(), nullptr));
  }
  [[nodiscard]] Volume fresh() const { return open(device_, folder_.file("p.bcc4")); }
  [[nodiscard]] static uint64_t bytes_read(const Volume& v) {
    auto info = sized<bccsplat_volume_info>();
    EXPECT_OK(bccsplat_volume_get_info(v.get(), &info));
    return info.bytes_read;
  }
  [[nodiscard]] Vec4 world(const Vec4& p) const {
    Vec4 out{0, 0, 0, 0};
    for (size_t r = 0; r < 3; ++r)
      out[r] =
          affine_[4 * r] * p[0] + affine_[4 * r + 1] * p[1] + affine_[4 * r + 2] * p[2] + affine_[4 * r + 3];
    out[3] = times[static_cast<size_t>(p[3])];
    return out;
  }

  const Folder folder_;
  const Device device_ = make_device();
  Series series_;
  double affine_[16] = {};
};

TEST_F(Probes, VoxelCentresOfTheFacesAreInside) {
  const Volume v = fresh();
  std::vector<Vec4> at, index;
  constexpr double last = n - 1;
  for (double a = 0; a < n; a += 5)
    for (double b = 0; b < n; b += 5)
      for (const double face : {0.0, last})
        for (const Vec4& p : {Vec4{face, a, b, 4}, Vec4{a, face, b, 0}, Vec4{a, b, face, 4}})
          index.push_back(p), at.push_back(world(p));
  std::vector<float> values(at.size()), expected(at.size());
  ASSERT_OK(
      bccsplat_volume_evaluate_world(v.get(), 0, at.size(), at[0].data(), values.data(), nullptr, nullptr));
  ASSERT_OK(bccsplat_volume_evaluate(v.get(), at.size(), index[0].data(), expected.data(), nullptr));
  for (size_t i = 0; i < at.size(); ++i) ASSERT_NEAR(values[i], expected[i], 1e-3) << i;
  // What a host's own inverse leaves.
  const double beside[][4] = {{-1e-14, 5, last + 1e-13, 4 + 1e-15}, {5, last + 1e-13, -1e-12, -1e-16}};
  float value[2];
  ASSERT_OK(bccsplat_volume_evaluate(v.get(), 2, beside[0], value, nullptr));
  EXPECT_TRUE(std::isfinite(value[0]) && std::isfinite(value[1]));
  const double outside[][4] = {{5, 5, 5, 1}, {5, last + 1e-3, 5, 1}};
  EXPECT_EQ(bccsplat_volume_evaluate(v.get(), 2, outside[0], value, nullptr), BCCSPLAT_ERROR_OUT_OF_DOMAIN);
  EXPECT_NE(std::string(bccsplat_last_error()).find("point 1 has the index 95.001 along y, outside 0 to 95"),
            std::string::npos)
      << bccsplat_last_error();
}

TEST_F(Probes, GradientsOfTheWorldAreDifferencesInIt) {
  const Volume v = fresh();
  const Vec4 at = world({40, 52, 33, 2});
  const double h = 1e-2;
  for (const double time : {11.1, 12.1, 13.3}) {
    std::array<Vec4, 9> points;
    points.fill({at[0], at[1], at[2], time});
    for (size_t a = 0; a < 4; ++a) points[1 + 2 * a][a] += h, points[2 + 2 * a][a] -= h;
    std::array<float, 9> values;
    std::array<std::array<float, 4>, 9> slopes;
    ASSERT_OK(bccsplat_volume_evaluate_world(v.get(), 0, 9, points[0].data(), values.data(), slopes[0].data(),
                                             nullptr));
    for (size_t a = 0; a < 4; ++a)
      EXPECT_NEAR(slopes[0][a], (values[1 + 2 * a] - values[2 + 2 * a]) / (2 * h), 0.02) << time << " " << a;
  }
  float value = 0;
  const Vec4 late{at[0], at[1], at[2], 15};
  EXPECT_EQ(bccsplat_volume_evaluate_world(v.get(), 0, 1, late.data(), &value, nullptr, nullptr),
            BCCSPLAT_ERROR_OUT_OF_DOMAIN);
  EXPECT_TRUE(std::isnan(value));
  EXPECT_NE(std::string(bccsplat_last_error()).find("time 15, outside 10 to 14"), std::string::npos)
      << bccsplat_last_error();
}

TEST_F(Probes, ReadWhatLiesAroundThemUntilThatIsAll) {
  const Volume all = fresh(), few = fresh();
  std::vector<Vec4> spread;
  for (double x = 0; x < n; x += 19)
    for (double y = 0; y < n; y += 19)
      for (double z = 0; z < n; z += 19) spread.push_back({x, y, z, 1.3});
  std::vector<float> values(spread.size());
  const uint64_t before = bytes_read(all);
  ASSERT_OK(bccsplat_volume_evaluate(all.get(), spread.size(), spread[0].data(), values.data(), nullptr));
  const uint64_t whole = bytes_read(all) - before;
  float one = 0;
  ASSERT_OK(bccsplat_volume_evaluate(few.get(), 1, spread[0].data(), &one, nullptr));
  EXPECT_EQ(one, values[0]);
  const uint64_t first = bytes_read(few) - before;
  EXPECT_LT(first, whole / 2);
  const Vec4 beside{3, 2, 4, 1.3};
  ASSERT_OK(bccsplat_volume_evaluate(few.get(), 1, beside.data(), &one, nullptr));
  EXPECT_EQ(bytes_read(few) - before, first) << "that is there";
  for (size_t i = 0; i < spread.size(); ++i) {
    ASSERT_OK(bccsplat_volume_evaluate(few.get(), 1, spread[i].data(), &one, nullptr));
    EXPECT_EQ(one, values[i]) << i;
  }
  EXPECT_LT(bytes_read(few) - before, 4 * whole) << "points all over the volume, one by one";
}

// Two ends of a long box, at every frame: what lies between them is not read.
TEST(ProbesInFewPlaces, ReadWhatLiesAroundEach) {
  const Folder folder;
  const Device device = make_device();
  Series s;
  s.nx = s.ny = 24, s.nz = 600, s.nt = 5;
  s.field = [](double x, double y, double z, double t) {
    return 50 + 20 * std::sin(0.3 * x + 0.2 * z) + 5 * std::cos(0.4 * y + t);
  };
  (void)write_series(device, folder.file("long.bcc4"), s);
  std::vector<Vec4> points;
  for (int n = 0; n < 500; ++n)
    for (double t = 0; t < s.nt; ++t)
      points.push_back({1.0 + n % 20, 2.0 + n % 19, n % 2 ? 3.0 + n % 7 : 590.0 - n % 5, t});
  const auto read_by = [&](const std::vector<Vec4>& at, std::vector<float>& values) {
    const Volume v = open(device, folder.file("long.bcc4"));
    auto info = sized<bccsplat_volume_info>();
    EXPECT_OK(bccsplat_volume_get_info(v.get(), &info));
    const uint64_t before = info.bytes_read;
    values.resize(at.size());
    EXPECT_OK(bccsplat_volume_evaluate(v.get(), at.size(), at[0].data(), values.data(), nullptr));
    EXPECT_OK(bccsplat_volume_get_info(v.get(), &info));
    return info.bytes_read - before;
  };
  std::vector<float> all, near, far, spread;
  std::vector<Vec4> ends[2], along;
  for (const Vec4& p : points) ends[p[2] < 300 ? 0 : 1].push_back(p);
  for (double z = 0; z < s.nz; z += 10) along.push_back({12, 12, z, 2});
  const uint64_t both = read_by(points, all), one = read_by(ends[0], near), other = read_by(ends[1], far),
                 whole = read_by(along, spread);
  EXPECT_LE(both, one + other);
  EXPECT_LT(both, whole / 2);
  size_t n = 0, f = 0;
  for (size_t p = 0; p < points.size(); ++p)
    ASSERT_EQ(all[p], points[p][2] < 300 ? near[n++] : far[f++]) << p << ": in the order of the points";
}

} // namespace
