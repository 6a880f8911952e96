// SPDX-License-Identifier: Apache-2.0
// Every way of looking at a file with a bound sees its corrections: what was promised is what is drawn.
#include <random>

#include "fit_writer.h"

namespace bccsplat::test {
namespace {

// Like a beating heart in air: hard edges that move, thin vessels, single bright samples.
double heart(double x, double y, double z, double t) {
  const double r = 6 + 1.5 * std::sin(1.3 * t);
  const double d = std::hypot(x - 11, y - 10, 1.4 * (z - 7));
  if (std::fabs(x - 0.7 * y - 2) < 0.6 && z > 2) return 1.7; // a vessel
  if (static_cast<int>(x + 3 * y + 5 * z + 7 * t) % 41 == 0) return 1.2;
  return d < r ? (d < r - 2 ? 0.8 : 2) : 0;
}

constexpr double bound = 0.02;

struct HeartFiles {
  TestDevice device;
  Source source = source_of({24, 22, 14, 9}, BCCSPLAT_TYPE_F32, heart);
  Bytes plain, fixed;

  HeartFiles() {
    auto options = sized<bccsplat_writer_options>();
    options.scale = 1.5, options.time_scale = 1.5; // the lattice alone is far off
    plain = write_frames(device, source, options).bytes;
    options.abs_error = bound;
    const Written w = write_frames(device, source, options);
    EXPECT_EQ(w.status, BCCSPLAT_OK) << w.text;
    EXPECT_GT(w.error.uncorrected_max_abs, 20 * bound);
    fixed = w.bytes;
  }
  [[nodiscard]] double at(uint64_t x, uint64_t y, uint64_t z, uint64_t t) const {
    const auto& n = source.dims;
    return source.values[((t * n[2] + z) * n[1] + y) * n[0] + x];
  }
};

const HeartFiles& heart_files() {
  static const HeartFiles all;
  return all;
}

// Points inside the series, a little off its ends and off whole indices.
std::vector<std::array<double, 4>> points_inside(size_t count) {
  std::mt19937 random(5);
  std::vector<std::array<double, 4>> points(count);
  for (auto& p : points)
    for (size_t a = 0; a < 4; ++a) {
      const double cells = heart_files().source.dims[a] - 1.0;
      p[a] = std::floor(std::uniform_real_distribution<double>(0, cells)(random)) +
             std::uniform_real_distribution<double>(0.05, 0.95)(random);
    }
  return points;
}

TEST(CorrectedField, GradientsAreThoseOfTheValues) {
  const OpenVolume volume(heart_files().device, heart_files().fixed);
  const auto points = points_inside(300);
  std::vector<float> values(points.size()), slopes(4 * points.size());
  ASSERT_EQ(
      bccsplat_volume_evaluate(volume.volume, points.size(), points[0].data(), values.data(), slopes.data()),
      BCCSPLAT_OK);
  constexpr double h = 2e-3;
  for (size_t a = 0; a < 4; ++a) {
    auto low = points, high = points;
    for (size_t i = 0; i < points.size(); ++i) low[i][a] -= h, high[i][a] += h;
    const auto before = volume.at(low), after = volume.at(high);
    for (size_t i = 0; i < points.size(); ++i)
      EXPECT_NEAR(slopes[4 * i + a], double(after[i] - before[i]) / (2 * h), 2e-3) << a << " " << i;
  }
}

// x, y and z slices hold the source as well as frames do, though their own kernel is another one.
TEST(CorrectedField, AxisSlicesKeepWhatWasPromised) {
  const HeartFiles& f = heart_files();
  const auto& n = f.source.dims;
  const OpenVolume plain(f.device, f.plain), fixed(f.device, f.fixed);
  const auto largest = [&](const OpenVolume& volume, size_t axis, uint64_t at) {
    std::array<double, 5> h{0, 0, 0, 0, -double(at)};
    h[axis] = 1;
    const Cut cut(volume, h);
    const auto values = cut.samples();
    double most = 0;
    for (size_t i = 0; i < values.size(); ++i) {
      const auto p = cut.place(i);
      most = larger(most, std::fabs(double(values[i]) - f.at(uint64_t(p[0] + 0.5), uint64_t(p[1] + 0.5),
                                                             uint64_t(p[2] + 0.5), uint64_t(p[3] + 0.5))));
    }
    EXPECT_EQ(values.size(), uint64_t{n[0]} * n[1] * n[2] * n[3] / n[axis]);
    return most;
  };
  for (size_t axis = 0; axis < 3; ++axis)
    for (const uint64_t at : {uint64_t{0}, uint64_t{n[axis]} / 2, uint64_t{n[axis]} - 1}) {
      EXPECT_GT(largest(plain, axis, at), 10 * bound);
      EXPECT_LE(largest(fixed, axis, at), bound * (1 + 1.0 / 32)) << axis << " = " << at;
    }
}

// Any other slice agrees with the volume at the points that it is sampled at, and thick ones with their mean.
TEST(CorrectedField, ObliqueSlicesShowTheFieldOfTheVolume) {
  const HeartFiles& f = heart_files();
  const OpenVolume plain(f.device, f.plain), fixed(f.device, f.fixed);
  const auto difference = [&](const OpenVolume& volume, std::array<double, 5> h, const OpenVolume& of) {
    const Cut cut(volume, h);
    const auto values = cut.samples();
    std::vector<std::array<double, 4>> places;
    for (size_t i = 0; i < values.size(); ++i) places.push_back(cut.place(i));
    const auto field = of.at(places);
    double most = 0;
    size_t both = 0;
    for (size_t i = 0; i < values.size(); ++i)
      if (!std::isnan(values[i]) && !std::isnan(field[i]))
        ++both, most = larger(most, std::fabs(double(values[i] - field[i])));
    EXPECT_GT(both, 500u);
    return most;
  };
  for (const std::array<double, 5>& h : {std::array<double, 5>{1, 0.6, 0, 0.8, -14},
                                         {0, 0.3, 1, -0.9, -5},
                                         {1, 0, 0, 1, -12},
                                         {1, 0, 0, 0, -7.3},
                                         {0.2, 0.3, 0.1, 1, -8}}) {
    EXPECT_LE(difference(fixed, h, fixed), bound / 32 + 1e-5);
    EXPECT_GT(difference(plain, h, fixed), 5 * bound);
  }
}

TEST(CorrectedField, ThickSlicesHoldTheirCorrections) {
  const HeartFiles& f = heart_files();
  const OpenVolume fixed(f.device, f.fixed);
  // Means by many points across: over time, along x, and the sum along z.
  const auto mean = [&](std::array<double, 4> p, const std::array<double, 4>& normal, double length) {
    std::vector<std::array<double, 4>> line;
    for (int k = 0; k < 400; ++k) {
      line.push_back(p);
      for (size_t a = 0; a < 4; ++a) line.back()[a] += normal[a] * length * ((k + 0.5) / 400 - 0.5);
    }
    double sum = 0;
    for (const float v : fixed.at(line)) sum += double(v) / 400;
    return sum;
  };
  const auto check = [&](std::array<double, 5> h, const bccsplat_slice_options& options, double length,
                         double factor, double tolerance) {
    const Cut cut(fixed, h, options);
    const auto values = cut.samples();
    for (size_t i = 0; i < values.size(); i += 97) {
      const auto p = cut.place(i);
      EXPECT_NEAR(double(values[i]), factor * mean(p, {h[0], h[1], h[2], h[3]}, length), tolerance) << i;
    }
  };
  auto interval = sized<bccsplat_slice_options>();
  interval.interval[0] = -1.5, interval.interval[1] = 1.5;
  check({0, 0, 0, 1, -4}, interval, 3, 1, 1e-3);
  auto thick = sized<bccsplat_slice_options>();
  thick.thickness = 3;
  check({0, 0, 0, 1, -4}, thick, 3, 1, 1e-3);
  thick.slab = BCCSPLAT_SLAB_SUM;
  check({0, 0, 0, 1, -4}, thick, 3, 3, 3e-3);
  // Along other axes by quadrature, which the edges of the fall-off keep from converging fast.
  thick.slab = BCCSPLAT_SLAB_MEAN;
  check({1, 0, 0, 0, -11}, thick, 3, 1, 0.03);
}

// ---- Pictures ----

struct Look {
  int32_t mode = BCCSPLAT_MODE_COMPOSITE, quality = BCCSPLAT_QUALITY_BEST;
  int32_t reference = 0, tile_size = 0, projection = BCCSPLAT_PROJECTION_ORTHOGRAPHIC;
  uint32_t disable_skips = 0, planes = BCCSPLAT_FRAME_RGBA;
  double low = 0.5, iso = 1; // low: of the opacity
  int32_t smooth_edges = BCCSPLAT_SMOOTH_EDGES_DEFAULT;
  const bccsplat_trail* trail = nullptr;
  uint32_t size = 72;
};

std::vector<float> heart_picture(const Cut& cut, const TestDevice& device, const Look& look) {
  bccsplat_renderer* renderer = nullptr;
  EXPECT_EQ(bccsplat_renderer_create(device.device, &renderer), BCCSPLAT_OK);
  EXPECT_EQ(bccsplat_renderer_set_slice(renderer, cut.slice), BCCSPLAT_OK);
  const double colors[] = {0, 1, 0.2, 0.1, 2, 0.2, 0.8, 1},
               opacities[] = {look.low, 0, look.low + 0.2, 0.25, 2, 0.6};
  auto function = sized<bccsplat_transfer_function>();
  function.colors = colors, function.color_count = 2, function.opacities = opacities,
  function.opacity_count = 3;
  EXPECT_EQ(bccsplat_renderer_set_transfer_function(renderer, &function), BCCSPLAT_OK);
  auto camera = sized<bccsplat_camera>();
  EXPECT_EQ(bccsplat_slice_fit_camera(cut.slice, look.projection, 25, 35, look.size, look.size, &camera),
            BCCSPLAT_OK);
  EXPECT_EQ(bccsplat_renderer_set_camera(renderer, &camera), BCCSPLAT_OK);
  auto options = sized<bccsplat_render_options>();
  options.mode = look.mode, options.quality = look.quality, options.reference = look.reference;
  options.tile_size = look.tile_size, options.disable_skips = look.disable_skips;
  options.smooth_edges = look.smooth_edges;
  if (look.mode == BCCSPLAT_MODE_ISOSURFACE)
    options.iso_value = look.iso, options.set_mask = BCCSPLAT_RENDER_SET_ISO;
  EXPECT_EQ(bccsplat_renderer_set_options(renderer, &options), BCCSPLAT_OK) << bccsplat_last_error();
  EXPECT_EQ(bccsplat_renderer_set_trail(renderer, look.trail), BCCSPLAT_OK) << bccsplat_last_error();
  bccsplat_frame* frame = nullptr;
  EXPECT_EQ(bccsplat_frame_create(device.device, look.size, look.size, look.planes, &frame), BCCSPLAT_OK);
  EXPECT_EQ(bccsplat_renderer_render(renderer, frame), BCCSPLAT_OK) << bccsplat_last_error();
  std::vector<float> pixels;
  if (look.planes & BCCSPLAT_FRAME_DEEP) {
    auto deep = sized<bccsplat_deep>();
    EXPECT_EQ(bccsplat_frame_get_deep(frame, &deep), BCCSPLAT_OK);
    pixels.push_back(static_cast<float>(deep.first[size_t{look.size} * look.size]));
  } else {
    auto plane = sized<bccsplat_plane>();
    EXPECT_EQ(bccsplat_frame_get_channel(frame, BCCSPLAT_FRAME_RGBA, &plane), BCCSPLAT_OK);
    for (uint32_t y = 0; y < look.size; ++y) {
      const float* row = plane.pixels + y * (plane.row_bytes / sizeof(float));
      pixels.insert(pixels.end(), row, row + 4 * size_t{look.size});
    }
  }
  bccsplat_frame_release(frame);
  bccsplat_renderer_release(renderer);
  return pixels;
}

double rms(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += double(a[i] - b[i]) * double(a[i] - b[i]);
  return std::sqrt(sum / double(a.size()));
}

constexpr std::array<double, 5> now{0, 0, 0, 1, -3.3};

// Against rays through the same field in fine steps; the bare lattice is far from them.
TEST(CorrectedField, PicturesShowIt) {
  const HeartFiles& f = heart_files();
  const OpenVolume plain(f.device, f.plain), fixed(f.device, f.fixed);
  for (const std::array<double, 5>& h :
       {now, std::array<double, 5>{1, 0, 0, 0, -11}, std::array<double, 5>{1, 0.6, 0, 0.8, -14}}) {
    const Cut bare(plain, h), corrected(fixed, h);
    for (const int32_t mode :
         {BCCSPLAT_MODE_COMPOSITE, BCCSPLAT_MODE_ISOSURFACE, BCCSPLAT_MODE_XRAY, BCCSPLAT_MODE_MAXIMUM})
      for (const int32_t projection : {BCCSPLAT_PROJECTION_ORTHOGRAPHIC, BCCSPLAT_PROJECTION_PERSPECTIVE}) {
        if (h != now && (mode > BCCSPLAT_MODE_ISOSURFACE || projection > BCCSPLAT_PROJECTION_ORTHOGRAPHIC))
          continue;
        SCOPED_TRACE(std::to_string(mode) + " " + std::to_string(projection) + " " + std::to_string(h[0]));
        Look look;
        look.mode = mode, look.projection = projection, look.reference = 1, look.size = 60;
        look.smooth_edges = BCCSPLAT_SMOOTH_EDGES_OFF; // the reference has one sample per pixel
        const auto truth = heart_picture(corrected, f.device, look);
        look.reference = 0;
        const double without = rms(heart_picture(bare, f.device, look), truth);
        EXPECT_LT(rms(heart_picture(corrected, f.device, look), truth), 0.3 * without);
        look.quality = BCCSPLAT_QUALITY_NORMAL;
        EXPECT_LT(rms(heart_picture(corrected, f.device, look), truth), 0.6 * without);
      }
  }
}

// Sheets stand as close as the source's samples however coarse the lattice is.
TEST(CorrectedField, PicturesOfCoarseLatticesShowIt) {
  const HeartFiles& f = heart_files();
  auto options = sized<bccsplat_writer_options>();
  options.scale = 4, options.abs_error = bound;
  const Bytes coarse = write_frames(f.device, f.source, options).bytes;
  const OpenVolume volume(f.device, coarse);
  const Cut cut(volume, now);
  Look look;
  look.quality = BCCSPLAT_QUALITY_NORMAL, look.reference = 1, look.size = 60;
  const auto truth = heart_picture(cut, f.device, look);
  look.reference = 0;
  EXPECT_LT(rms(heart_picture(cut, f.device, look), truth), 0.02);
}

// What nothing but corrections holds: the lattice of these files is air everywhere.
TEST(CorrectedField, NothingIsLeftOutThatOnlyCorrectionsShow) {
  const TestDevice device;
  Source s = source_of({40, 30, 26, 3}, BCCSPLAT_TYPE_F32, [](double x, double y, double z, double) {
    const int n = static_cast<int>(x) * 7 + static_cast<int>(y) * 13 + static_cast<int>(z) * 29;
    return n % 97 == 0 ? 0.9 : 0.0;
  });
  s.threshold = 1;
  auto options = sized<bccsplat_writer_options>();
  options.abs_error = 0.01;
  const Written w = write_frames(device, s, options);
  ASSERT_EQ(w.status, BCCSPLAT_OK) << w.text;
  EXPECT_EQ(w.report.sites_kept, 0u);
  const OpenVolume volume(device, w.bytes);
  const Cut cut(volume, {0, 0, 0, 1, -1});
  EXPECT_GE(cut.info.bounds[1], 0.89);
  for (const int32_t mode : {BCCSPLAT_MODE_COMPOSITE, BCCSPLAT_MODE_ISOSURFACE})
    for (const int32_t quality : {BCCSPLAT_QUALITY_DRAFT, BCCSPLAT_QUALITY_NORMAL, BCCSPLAT_QUALITY_BEST}) {
      Look look;
      look.mode = mode, look.quality = quality, look.low = 0.3, look.iso = 0.5;
      const auto some = heart_picture(cut, device, look);
      look.disable_skips = BCCSPLAT_SKIP_TRANSFER_FUNCTION | BCCSPLAT_SKIP_FRUSTUM | BCCSPLAT_SKIP_OCCLUSION |
                           BCCSPLAT_SKIP_EMPTY_SHEETS;
      EXPECT_EQ(some, heart_picture(cut, device, look));
      look.tile_size = 24;
      EXPECT_EQ(some, heart_picture(cut, device, look));
      double light = 0;
      for (size_t i = 3; i < some.size(); i += 4) light += double(some[i]);
      EXPECT_GT(light, mode == BCCSPLAT_MODE_COMPOSITE ? 20 : 0);
    }
  Look deep;
  deep.planes = BCCSPLAT_FRAME_RGBA | BCCSPLAT_FRAME_DEEP, deep.low = 0.3;
  EXPECT_GT(heart_picture(cut, device, deep)[0], 100);
  auto trail = sized<bccsplat_trail>();
  trail.interval[0] = -1, trail.interval[1] = 0;
  Look moved;
  moved.trail = &trail, moved.low = 0.3;
  EXPECT_GT(rms(heart_picture(cut, device, moved), std::vector<float>(4 * 72 * 72)), 0.01);
}

// No skip changes a bit where lattice and corrections mix, nor does any size of tiles.
TEST(CorrectedField, SkipsAndTilesChangeNoBit) {
  const HeartFiles& f = heart_files();
  const OpenVolume fixed(f.device, f.fixed);
  const Cut cut(fixed, now);
  for (const int32_t mode : {BCCSPLAT_MODE_COMPOSITE, BCCSPLAT_MODE_ISOSURFACE})
    for (const double low : {0.5, 1.75}) {
      Look look;
      look.mode = mode, look.quality = BCCSPLAT_QUALITY_NORMAL, look.low = low;
      const auto some = heart_picture(cut, f.device, look);
      look.tile_size = 40;
      EXPECT_EQ(some, heart_picture(cut, f.device, look));
      look.tile_size = 0, look.disable_skips = 15;
      EXPECT_LT(rms(some, heart_picture(cut, f.device, look)), 1e-6);
    }
}

// A trail of stills that have corrections of their own moments.
TEST(CorrectedField, TrailsShowIt) {
  const HeartFiles& f = heart_files();
  auto options = sized<bccsplat_writer_options>();
  options.scale = options.time_scale = 0.5; // dense: the lattice alone is near the source
  const Bytes near = write_frames(f.device, f.source, options).bytes;
  const OpenVolume plain(f.device, f.plain), fixed(f.device, f.fixed), dense(f.device, near);
  auto trail = sized<bccsplat_trail>();
  trail.interval[0] = -2, trail.interval[1] = 0, trail.samples = 5;
  Look look;
  look.trail = &trail;
  const auto shown = [&](const OpenVolume& volume) {
    const Cut cut(volume, {0, 0, 0, 1, -6});
    return heart_picture(cut, f.device, look);
  };
  const auto truth = shown(dense);
  EXPECT_LT(rms(shown(fixed), truth), 0.6 * rms(shown(plain), truth));
}

TEST(CorrectedField, InfoSaysWhatItTakes) {
  const HeartFiles& f = heart_files();
  const OpenVolume plain(f.device, f.plain), fixed(f.device, f.fixed);
  auto info = sized<bccsplat_channel_info>();
  ASSERT_EQ(bccsplat_volume_get_channel_info(plain.volume, 0, &info), BCCSPLAT_OK);
  EXPECT_EQ(info.corrections, 0u);
  EXPECT_EQ(info.lattice_rmse, 0);
  ASSERT_EQ(bccsplat_volume_get_channel_info(fixed.volume, 0, &info), BCCSPLAT_OK);
  auto options = sized<bccsplat_writer_options>();
  options.scale = 1.5, options.time_scale = 1.5, options.abs_error = bound;
  const Written w = write_frames(f.device, f.source, options);
  EXPECT_EQ(info.corrections, w.report.corrected);
  const auto expect_digits = [](double told, double measured) { // three of them
    EXPECT_LE(told, measured);
    EXPECT_GE(told, measured * (1 - 1e-3));
  };
  expect_digits(info.rmse, w.error.rmse);
  expect_digits(info.max_abs, w.error.max_abs);
  expect_digits(info.lattice_max_abs, w.error.uncorrected_max_abs);
  EXPECT_GT(info.lattice_rmse, 5 * bound);
  EXPECT_LT(info.lattice_rmse, info.lattice_max_abs);
}

} // namespace
} // namespace bccsplat::test
