// SPDX-License-Identifier: Apache-2.0
// The slice options of the ABI: slabs, lattices, methods, hyperplanes by point and basis, empty slices.
#include <cmath>
#include <limits>
#include <numeric>
#include <thread>

#include "support.h"

using namespace host;

namespace {

class SliceOptions : public testing::Test {
 protected:
  static constexpr uint32_t frames = 14;
  Folder folder;
  Device device = make_device();
  Volume volume;

  void SetUp() override {
    Series s;
    s.nt = frames;
    (void)write_series(device, folder.file("s.bcc4"), s);
    volume = open(device, folder.file("s.bcc4"));
  }
  bccsplat_status create(const double (&h)[5], const bccsplat_slice_options& o, Slice& out) {
    auto plane = sized<bccsplat_hyperplane>();
    plane.a = h[0], plane.b = h[1], plane.c = h[2], plane.d = h[3], plane.e = h[4];
    bccsplat_slice* s = nullptr;
    const bccsplat_status status = bccsplat_slice_create(volume.get(), &plane, &o, &s);
    out.reset(s);
    return status;
  }
  Slice cut_with(const double (&h)[5], const bccsplat_slice_options& o) {
    Slice s;
    EXPECT_OK(create(h, o, s));
    return s;
  }
  static bccsplat_slice_info info_of(const Slice& s) {
    auto info = sized<bccsplat_slice_info>();
    EXPECT_OK(bccsplat_slice_get_info(s.get(), &info));
    return info;
  }
  // Root of the mean squared difference from the blob at samples of the dense box. Only outside of the domain
  // may a sample be NaN, which does not count.
  static double error_of(const Slice& s, double factor = 1) {
    const auto info = info_of(s);
    std::vector<float> v(info.dims[0] * info.dims[1] * info.dims[2]);
    EXPECT_OK(bccsplat_slice_sample_grid(s.get(), nullptr, v.data()));
    double sum = 0, count = 0, within = 0;
    for (size_t n = 0; n < v.size(); ++n) {
      const double at[3] = {info.extent[0][0] + double(n % info.dims[0]),
                            info.extent[1][0] + double(n / info.dims[0] % info.dims[1]),
                            info.extent[2][0] + double(n / info.dims[0] / info.dims[1])};
      double p[4];
      for (int i = 0; i < 4; ++i) {
        p[i] = info.origin[i];
        for (int k = 0; k < 3; ++k) p[i] += at[k] * info.basis[k][i];
      }
      const bool inside = p[0] >= 0 && p[0] <= Series{}.nx - 1 && p[1] >= 0 && p[1] <= Series{}.ny - 1 &&
                          p[2] >= 0 && p[2] <= Series{}.nz - 1 && p[3] >= 0 && p[3] <= frames - 1;
      within += inside ? 1 : 0;
      if (std::isnan(v[n])) continue;
      sum += std::pow(v[n] - factor * blob(p[0], p[1], p[2], p[3]), 2), ++count;
    }
    EXPECT_GT(within, 100);
    EXPECT_GE(count, within); // each sample in the domain has a value
    return std::sqrt(sum / count);
  }
};

constexpr double time_plane[5] = {0, 0, 0, 1, -6.3}, x_plane[5] = {1, 0, 0, 0, -9.2},
                 oblique[5] = {1, 0.4, 0, 0.5, -15};

TEST_F(SliceOptions, EveryMethodHoldsTheField) {
  for (const auto& h : {time_plane, x_plane, oblique}) {
    auto o = sized<bccsplat_slice_options>();
    const double ours = error_of(cut_with(*reinterpret_cast<const double(*)[5]>(h), o));
    EXPECT_LT(ours, 0.5);
    o.method = BCCSPLAT_METHOD_RESAMPLED;
    EXPECT_LT(error_of(cut_with(*reinterpret_cast<const double(*)[5]>(h), o)), 0.5);
    o.lattice = BCCSPLAT_LATTICE_CC;
    const Slice cc = cut_with(*reinterpret_cast<const double(*)[5]>(h), o);
    EXPECT_EQ(info_of(cc).lattice, BCCSPLAT_LATTICE_CC);
    EXPECT_LT(error_of(cc), 0.6);
    o.lattice = BCCSPLAT_LATTICE_DEFAULT;
    o.method = BCCSPLAT_METHOD_EXTRACTED;
    const Slice extracted = cut_with(*reinterpret_cast<const double(*)[5]>(h), o);
    EXPECT_LT(error_of(extracted), 6); // a Gaussian without prefilter
    EXPECT_GT(error_of(extracted), ours);
    uint64_t count = 0;
    ASSERT_OK(bccsplat_slice_get_points(extracted.get(), 0, nullptr, nullptr, &count));
    EXPECT_EQ(count, info_of(extracted).points);
    EXPECT_GT(count, 0u);
  }
}

TEST_F(SliceOptions, MergedWhereItCanBe) {
  auto o = sized<bccsplat_slice_options>();
  o.method = BCCSPLAT_METHOD_MERGED;
  Slice s;
  EXPECT_OK(create(time_plane, o, s));
  EXPECT_OK(create(x_plane, o, s));
  EXPECT_EQ(create(oblique, o, s), BCCSPLAT_ERROR_UNSUPPORTED);
  EXPECT_FALSE(s);
  o.lattice = BCCSPLAT_LATTICE_CC;
  EXPECT_EQ(create(x_plane, o, s), BCCSPLAT_ERROR_UNSUPPORTED);
}

TEST_F(SliceOptions, SumIsThicknessTimesMean) {
  for (const auto& h : {time_plane, x_plane, oblique}) {
    const auto& plane = *reinterpret_cast<const double(*)[5]>(h);
    auto o = sized<bccsplat_slice_options>();
    o.thickness = 2.5;
    const Slice mean = cut_with(plane, o);
    o.slab = BCCSPLAT_SLAB_SUM;
    const Slice sum = cut_with(plane, o);
    o.slab = BCCSPLAT_SLAB_MAXIMUM;
    const Slice maximum = cut_with(plane, o);
    const auto info = info_of(mean);
    double centre[3];
    for (int a = 0; a < 3; ++a) centre[a] = (info.extent[a][0] + info.extent[a][1]) / 2;
    float a = 0, b = 0, c = 0;
    ASSERT_OK(bccsplat_slice_evaluate(mean.get(), 1, centre, &a, nullptr));
    ASSERT_OK(bccsplat_slice_evaluate(sum.get(), 1, centre, &b, nullptr));
    ASSERT_OK(bccsplat_slice_evaluate(maximum.get(), 1, centre, &c, nullptr));
    EXPECT_GT(a, 1);
    EXPECT_NEAR(b, 2.5 * a, 0.05);
    EXPECT_GT(c, a);
  }
}

TEST_F(SliceOptions, PointAndBasis) {
  const double point[4] = {9, 10, 8.5, 6.2};
  const double basis[12] = {1, 1, 0, 0, 0, 0, 2, 0, 0, 0, 0, 3};
  auto o = sized<bccsplat_slice_options>();
  o.point = point, o.basis = basis;
  bccsplat_slice* raw = nullptr;
  ASSERT_OK(bccsplat_slice_create(volume.get(), nullptr, &o, &raw));
  const Slice s(raw);
  const auto info = info_of(s);
  for (int i = 0; i < 4; ++i) EXPECT_DOUBLE_EQ(info.origin[i], point[i]);
  EXPECT_NEAR(info.basis[0][0], std::sqrt(0.5), 1e-15);
  EXPECT_NEAR(info.basis[2][3], 1, 1e-15);
  EXPECT_LT(error_of(s), 0.5);
  const double at[3] = {0, 0, 0};
  float value = 0;
  ASSERT_OK(bccsplat_slice_evaluate(s.get(), 1, at, &value, nullptr));
  EXPECT_NEAR(value, blob(9, 10, 8.5, 6.2), 1);
  // Given twice, half, or without extent.
  auto h = sized<bccsplat_hyperplane>();
  h.d = 1;
  EXPECT_EQ(bccsplat_slice_create(volume.get(), &h, &o, &raw), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  o.basis = nullptr;
  EXPECT_EQ(bccsplat_slice_create(volume.get(), nullptr, &o, &raw), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  const double flat[12] = {1, 1, 0, 0, 0, 0, 2, 0, 2, 2, -1, 0};
  o.basis = flat;
  EXPECT_EQ(bccsplat_slice_create(volume.get(), nullptr, &o, &raw), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(raw, nullptr);
}

TEST_F(SliceOptions, OutsideIsEmptyEverywhere) {
  auto o = sized<bccsplat_slice_options>();
  for (const int32_t method : {BCCSPLAT_METHOD_DEFAULT, BCCSPLAT_METHOD_MERGED, BCCSPLAT_METHOD_RESAMPLED,
                               BCCSPLAT_METHOD_EXTRACTED}) {
    o.method = method;
    const Slice s = cut_with({0, 1, 0, 0, 4}, o);
    const auto info = info_of(s);
    EXPECT_EQ(info.points, 0u);
    for (int a = 0; a < 3; ++a) {
      EXPECT_EQ(info.dims[a], 0u);
      EXPECT_LT(info.extent[a][1], info.extent[a][0]);
    }
    float v[8] = {7, 7, 7, 7, 7, 7, 7, 7};
    EXPECT_OK(bccsplat_slice_sample_grid(s.get(), nullptr, v)); // nothing to fill in
    EXPECT_EQ(v[0], 7);
    auto grid = sized<bccsplat_grid>();
    for (int a = 0; a < 3; ++a) grid.step[a] = 1, grid.dims[a] = 2;
    EXPECT_OK(bccsplat_slice_sample_grid(s.get(), &grid, v));
    for (const float x : v) EXPECT_TRUE(std::isnan(x));
    const double at[3] = {0, 0, 0};
    EXPECT_EQ(bccsplat_slice_evaluate(s.get(), 1, at, v, nullptr), BCCSPLAT_ERROR_OUT_OF_DOMAIN);
    uint64_t count = 1;
    EXPECT_OK(bccsplat_slice_get_points(s.get(), 0, nullptr, nullptr, &count));
    EXPECT_EQ(count, 0u);
  }
}

TEST_F(SliceOptions, RenderingAnEmptySliceShowsNothing) {
  const Slice s = cut(volume, 0, 1, 0, 0, 4);
  bccsplat_renderer* r = nullptr;
  ASSERT_OK(bccsplat_renderer_create(device.get(), &r));
  const Renderer renderer(r);
  std::vector<float> rgba(16 * 16 * 4, 7);
  bccsplat_frame* f = nullptr;
  ASSERT_OK(bccsplat_frame_wrap(device.get(), 16, 16, rgba.data(), 0, &f));
  const Frame frame(f);
  ASSERT_OK(bccsplat_renderer_set_slice(r, s.get()));
  ASSERT_OK(bccsplat_renderer_render(r, f));
  for (const float v : rgba) ASSERT_EQ(v, 0);
  auto o = sized<bccsplat_slice_options>();
  o.method = BCCSPLAT_METHOD_EXTRACTED;
  const Slice extracted = cut_with(x_plane, o);
  ASSERT_OK(bccsplat_renderer_set_slice(r, extracted.get()));
  ASSERT_OK(bccsplat_renderer_render(r, f));
  EXPECT_GT(*std::max_element(rgba.begin(), rgba.end()), 0.1f);
}

// Two dozen sites around a box are less than a whole volume only where that is larger.
class SliceBox : public SliceOptions {
 protected:
  static constexpr double box[6] = {30, 4, 100, 37.5, 12, 130};
  static double sum_of(const Slice& s) {
    const auto info = info_of(s);
    std::vector<float> v(info.dims[0] * info.dims[1] * info.dims[2]);
    EXPECT_OK(bccsplat_slice_sample_grid(s.get(), nullptr, v.data()));
    return std::accumulate(v.begin(), v.end(), 0.0);
  }
  void SetUp() override {
    Series s;
    s.nx = 40, s.ny = 16, s.nz = 400, s.nt = 10;
    s.field = [](double x, double y, double z, double t) {
      return 50 + 20 * std::sin(0.4 * x + 0.3 * t) + 15 * std::cos(0.5 * y - 0.3 * z) +
             15 * std::sin(0.2 * z + t);
    };
    (void)write_series(device, folder.file("long.bcc4"), s);
    volume = open(device, folder.file("long.bcc4"));
  }
};

TEST_F(SliceBox, IsThatPartOfTheSlice) {
  auto o = sized<bccsplat_slice_options>();
  o.box = box;
  const Slice part = cut_with(time_plane, o);
  const auto info = info_of(part);
  for (int a = 0; a < 3; ++a) {
    EXPECT_NEAR(info.extent[a][0], box[a], 1e-9);
    EXPECT_NEAR(info.extent[a][1], box[a + 3], 1e-9);
    EXPECT_EQ(info.dims[a], uint64_t(box[a + 3] - box[a]) + 1);
  }
  o.box = nullptr;
  volume = open(device, folder.file("long.bcc4")); // nothing is cached
  const Slice whole = cut_with(time_plane, o);
  EXPECT_GT(info.bytes_read, 0u);
  EXPECT_LT(info.bytes_read, info_of(whole).bytes_read / 2);
  std::vector<float> some(info.dims[0] * info.dims[1] * info.dims[2]), same(some.size());
  ASSERT_OK(bccsplat_slice_sample_grid(part.get(), nullptr, some.data()));
  auto grid = sized<bccsplat_grid>();
  for (int a = 0; a < 3; ++a) grid.origin[a] = box[a], grid.step[a] = 1, grid.dims[a] = info.dims[a];
  ASSERT_OK(bccsplat_slice_sample_grid(whole.get(), &grid, same.data()));
  for (size_t i = 0; i < some.size(); ++i) ASSERT_NEAR(some[i], same[i], 1e-5);
  const double outside[3] = {30, 4, 99};
  float value = 0;
  EXPECT_EQ(bccsplat_slice_evaluate(part.get(), 1, outside, &value, nullptr), BCCSPLAT_ERROR_OUT_OF_DOMAIN);
  EXPECT_OK(bccsplat_slice_evaluate(whole.get(), 1, outside, &value, nullptr));
}

TEST_F(SliceBox, PlaysWithoutReadingAgain) {
  auto o = sized<bccsplat_slice_options>();
  o.box = box;
  (void)cut_with({0, 0, 0, 1, -4}, o);
  EXPECT_EQ(info_of(cut_with({0, 0, 0, 1, -4.25}, o)).bytes_read, 0u);
  EXPECT_EQ(info_of(cut_with({0, 0, 0, 1, -3.75}, o)).bytes_read, 0u);
}

TEST_F(SliceBox, IsPrefetched) {
  auto o = sized<bccsplat_slice_options>();
  auto plane = sized<bccsplat_hyperplane>();
  plane.d = 1, plane.e = -6.3;
  for (const double* part : {box, static_cast<const double*>(nullptr)}) {
    o.box = part;
    ASSERT_OK(bccsplat_volume_prefetch(volume.get(), &plane, &o));
    EXPECT_EQ(info_of(cut_with(time_plane, o)).bytes_read, 0u);
  }
  plane.e = -40;
  EXPECT_EQ(bccsplat_volume_prefetch(volume.get(), &plane, &o), BCCSPLAT_ERROR_OUT_OF_DOMAIN);
  plane.a = 1, plane.d = 0, plane.e = -9;
  EXPECT_EQ(bccsplat_volume_prefetch(volume.get(), &plane, &o), BCCSPLAT_ERROR_UNSUPPORTED);
  o.method = BCCSPLAT_METHOD_EXTRACTED;
  EXPECT_EQ(bccsplat_volume_prefetch(volume.get(), &plane, &o), BCCSPLAT_ERROR_UNSUPPORTED);
}

// Beside a slice that another thread makes.
TEST_F(SliceBox, IsPrefetchedWhileAnotherIsMade) {
  auto o = sized<bccsplat_slice_options>();
  std::thread ahead([&] {
    auto plane = sized<bccsplat_hyperplane>();
    plane.d = 1, plane.e = -7;
    EXPECT_OK(bccsplat_volume_prefetch(volume.get(), &plane, nullptr));
  });
  const double now = sum_of(cut_with(time_plane, o));
  ahead.join();
  EXPECT_EQ(sum_of(cut_with(time_plane, o)), now);
}

TEST_F(SliceBox, IsChecked) {
  const auto status = [&](std::array<double, 6> b, const double(&h)[5]) {
    auto o = sized<bccsplat_slice_options>();
    o.box = b.data();
    Slice s;
    return create(h, o, s);
  };
  EXPECT_EQ(status({5, 0, 0, 4, 9, 9}, time_plane), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(status({0, 0, 0, 4, 9, NAN}, time_plane), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(status({0, 0, 400, 4, 9, 500}, time_plane), BCCSPLAT_ERROR_OUT_OF_DOMAIN);
  EXPECT_EQ(status({-9, -9, -9, 400, 400, 400}, time_plane), BCCSPLAT_OK);
  EXPECT_EQ(status({3, 3, 3, 3, 3, 3}, time_plane), BCCSPLAT_OK); // one point
  EXPECT_EQ(status({0, 0, 0, 4, 9, 9}, x_plane), BCCSPLAT_ERROR_UNSUPPORTED);
  EXPECT_EQ(status({0, 0, 0, 4, 9, 9}, oblique), BCCSPLAT_ERROR_UNSUPPORTED);
}

// A picture of a box, still and with a trail, is that of the volume where its rays meet no more than the box.
TEST_F(SliceBox, IsDrawnAsTheVolumeIs) {
  auto o = sized<bccsplat_slice_options>();
  const double slab[6] = {0, 0, 100, 39, 15, 130}; // seen along x, with a margin above and below
  o.box = slab;
  const Slice part = cut_with(time_plane, o);
  o.box = nullptr;
  const Slice whole = cut_with(time_plane, o);
  auto camera = sized<bccsplat_camera>();
  ASSERT_OK(bccsplat_slice_fit_camera(part.get(), BCCSPLAT_PROJECTION_ORTHOGRAPHIC, 0, 90, 32, 32, &camera));
  camera.ortho_height = 12;
  for (const bool trail : {false, true}) {
    std::array<std::vector<float>, 2> picture;
    for (size_t k = 0; k < 2; ++k) {
      bccsplat_renderer* r = nullptr;
      ASSERT_OK(bccsplat_renderer_create(device.get(), &r));
      const Renderer renderer(r);
      ASSERT_OK(bccsplat_renderer_set_slice(r, (k == 0 ? part : whole).get()));
      ASSERT_OK(bccsplat_renderer_set_camera(r, &camera));
      auto motion = sized<bccsplat_trail>();
      motion.interval[0] = -2;
      ASSERT_OK(bccsplat_renderer_set_trail(r, trail ? &motion : nullptr));
      picture[k].resize(32 * 32 * 4);
      bccsplat_frame* f = nullptr;
      ASSERT_OK(bccsplat_frame_wrap(device.get(), 32, 32, picture[k].data(), 0, &f));
      const Frame frame(f);
      ASSERT_OK(bccsplat_renderer_render(r, f));
    }
    double most = 0;
    float seen = 0;
    for (size_t i = 0; i < picture[0].size(); ++i) {
      most = larger(most, std::fabs(picture[0][i] - picture[1][i]));
      seen = std::max(seen, picture[1][i]);
    }
    EXPECT_GT(seen, 0.1f) << trail;
    EXPECT_LT(most, 2e-3f) << trail;
  }
}

TEST_F(SliceOptions, AreChecked) {
  const auto status = [&](const std::function<void(bccsplat_slice_options&)>& change,
                          const double(&h)[5] = x_plane) {
    auto o = sized<bccsplat_slice_options>();
    change(o);
    Slice s;
    return create(h, o, s);
  };
  constexpr auto invalid = BCCSPLAT_ERROR_INVALID_ARGUMENT, unsupported = BCCSPLAT_ERROR_UNSUPPORTED;
  EXPECT_EQ(status([](auto& o) { o.thickness = -1; }), invalid);
  EXPECT_EQ(status([](auto& o) { o.thickness = NAN; }), invalid);
  EXPECT_EQ(status([](auto& o) { o.spacing = -1; }), invalid);
  EXPECT_EQ(status([](auto& o) { o.bandwidth[0] = 2; }), invalid); // the others are 0
  const auto wide = [](auto& o) { std::fill_n(o.bandwidth, 4, 2.0); };
  EXPECT_EQ(status(wide), unsupported); // by the default kernel
  const auto of_paper = [&](auto& o) { wide(o), o.kernel = "paper"; };
  EXPECT_EQ(status(of_paper), BCCSPLAT_OK);
  EXPECT_EQ(status([&](auto& o) { of_paper(o), o.method = BCCSPLAT_METHOD_EXTRACTED; }), unsupported);
  EXPECT_EQ(status([&](auto& o) { of_paper(o), o.thickness = 2; }), unsupported);
  EXPECT_EQ(status([](auto& o) { o.slab = 4; }), invalid);
  EXPECT_EQ(status([](auto& o) { o.method = 4; }), invalid);
  EXPECT_EQ(status([](auto& o) { o.lattice = BCCSPLAT_LATTICE_D4STAR; }), invalid);
  EXPECT_EQ(status([](auto& o) { o.thickness = 1, o.interval[1] = 1; }, time_plane), invalid);
  EXPECT_EQ(status([](auto& o) { o.interval[1] = 1; }), unsupported);
  EXPECT_EQ(status([](auto& o) { o.interval[1] = 1, o.lattice = BCCSPLAT_LATTICE_CC; }, time_plane),
            unsupported);
  EXPECT_EQ(status([](auto& o) { o.method = BCCSPLAT_METHOD_EXTRACTED, o.thickness = 1; }), unsupported);
}

} // namespace
