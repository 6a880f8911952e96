// SPDX-License-Identifier: Apache-2.0
// Views of a host's own: matrices of every convention, parts of pictures, its depths and pictures, clips.
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "support.h"

using namespace host;

namespace {

constexpr uint32_t width = 72, height = 48;
constexpr float infinite = std::numeric_limits<float>::infinity();

using Pixels = std::vector<float>; // 4 per pixel

double column(size_t pixel) { return static_cast<double>(pixel % width); }
double row_of(size_t pixel) { return static_cast<double>(pixel / width); }

class Views : public testing::Test {
 protected:
  void SetUp() override {
    device_ = make_device();
    Series s;
    s.field = [](double x, double y, double z, double t) {
      return 100 * std::exp(-(std::pow(x - 9, 2) + std::pow(y - 10 + t / 4, 2) + std::pow(z - 8, 2)) / 40);
    };
    auto o = options_of(s);
    // An oblique world: voxels of different lengths, turned and moved.
    constexpr std::array<double, 16> affine{1.2, -0.3, 0, 5, 0.4, 0.9, 0.2, -7, 0, -0.1, 1.5, 3, 0, 0, 0, 1};
    std::copy(affine.begin(), affine.end(), o.affine);
    const Writer writer = make_writer(device_, folder_.file("s.bcc4"), o);
    ASSERT_OK(add_frames(writer.get(), s));
    ASSERT_OK(bccsplat_writer_finish(writer.get(), nullptr));
    volume_ = open(device_, folder_.file("s.bcc4"));
    slice_ = cut_time(volume_, 2.5);
    bccsplat_renderer* r = nullptr;
    ASSERT_OK(bccsplat_renderer_create(device_.get(), &r));
    renderer_ = Renderer(r);
    ASSERT_OK(bccsplat_renderer_set_slice(r, slice_.get()));
    auto f = sized<bccsplat_transfer_function>();
    f.colors = colors_, f.color_count = 2, f.opacities = opacities_, f.opacity_count = 2;
    ASSERT_OK(bccsplat_renderer_set_transfer_function(r, &f));
    set_shading(BCCSPLAT_SHADING_OFF);
  }

  void set_shading(int32_t shading) {
    auto o = sized<bccsplat_render_options>();
    o.shading = shading;
    o.opacity_stop = 1;
    ASSERT_OK(bccsplat_renderer_set_options(renderer_.get(), &o));
  }
  [[nodiscard]] bccsplat_camera camera(bool perspective) const {
    auto c = sized<bccsplat_camera>();
    EXPECT_OK(bccsplat_slice_fit_camera(
        slice_.get(), perspective ? BCCSPLAT_PROJECTION_PERSPECTIVE : BCCSPLAT_PROJECTION_ORTHOGRAPHIC, 25,
        40, width, height, &c));
    return c;
  }
  [[nodiscard]] static bccsplat_view view_of(const bccsplat_camera& c) {
    auto v = sized<bccsplat_view>();
    v.camera = &c;
    return v;
  }
  [[nodiscard]] Pixels draw(const bccsplat_view* view, uint32_t w = width, uint32_t h = height) {
    bccsplat_frame* created = nullptr;
    EXPECT_OK(bccsplat_renderer_set_view(renderer_.get(), view));
    EXPECT_OK(bccsplat_frame_create(device_.get(), w, h, BCCSPLAT_FRAME_DEPTH, &created));
    const Frame frame(created);
    EXPECT_OK(bccsplat_renderer_render(renderer_.get(), created));
    auto plane = sized<bccsplat_plane>();
    EXPECT_OK(bccsplat_frame_get_channel(created, BCCSPLAT_FRAME_DEPTH, &plane));
    depth_.assign(plane.pixels, plane.pixels + size_t{w} * h);
    EXPECT_OK(bccsplat_frame_get_channel(created, BCCSPLAT_FRAME_RGBA, &plane));
    return {plane.pixels, plane.pixels + size_t{4} * w * h};
  }
  void clip(const std::vector<bccsplat_clip>& clips) {
    ASSERT_OK(bccsplat_renderer_set_clips(renderer_.get(), clips.data(), clips.size()));
  }

  const Folder folder_;
  Device device_;
  Volume volume_;
  Slice slice_;
  Renderer renderer_;
  Pixels depth_; // of the last picture, 1 per pixel
  double colors_[8] = {10, 1, 0.2, 0.1, 100, 0.2, 0.9, 1};
  double opacities_[4] = {5, 0, 90, 0.25};
};

float distance_to_target(const bccsplat_camera& c) {
  return static_cast<float>(
      std::hypot(c.target[0] - c.position[0], c.target[1] - c.position[1], c.target[2] - c.position[2]));
}

// A half-space behind the plane that faces the camera at this distance.
bccsplat_clip behind(const bccsplat_camera& c, double distance) {
  bccsplat_clip half{};
  double norm = 0;
  for (size_t a = 0; a < 3; ++a) norm += std::pow(c.target[a] - c.position[a], 2);
  for (size_t a = 0; a < 3; ++a) {
    half.normal[a] = (c.target[a] - c.position[a]) / std::sqrt(norm);
    half.offset -= half.normal[a] * c.position[a];
  }
  half.offset -= distance;
  return half;
}

// A depth range, whether +1 is the bottom, whether matrices are stored by columns.
struct Convention {
  int32_t range;
  uint32_t y_down, column_major;
};
constexpr std::array<Convention, 5> conventions{{{BCCSPLAT_DEPTH_RANGE_ZERO_ONE, 0, 0},
                                                 {BCCSPLAT_DEPTH_RANGE_ZERO_ONE, 1, 0},
                                                 {BCCSPLAT_DEPTH_RANGE_MINUS_ONE_ONE, 0, 1},
                                                 {BCCSPLAT_DEPTH_RANGE_REVERSED, 0, 0},
                                                 {BCCSPLAT_DEPTH_RANGE_REVERSED, 1, 1}}};

bccsplat_view matrix_view(const bccsplat_camera& c, const Convention& by, double near, double far) {
  auto v = sized<bccsplat_view>();
  v.use_matrices = 1, v.depth_range = by.range, v.y_down = by.y_down;
  EXPECT_OK(bccsplat_camera_get_matrices(&c, width, height, near, far, by.range, by.y_down, v.world_to_view,
                                         v.projection));
  v.column_major = by.column_major;
  for (double(*m)[16] : {&v.world_to_view, &v.projection})
    for (size_t r = 0; r < 4 && by.column_major; ++r)
      for (size_t k = 0; k < r; ++k) std::swap((*m)[4 * r + k], (*m)[4 * k + r]);
  return v;
}

// Device depth of a planar distance, by the matrices themselves.
float device_depth_of(const bccsplat_view& v, double distance) {
  const auto at = [&](size_t r, size_t k) { return v.projection[v.column_major ? 4 * k + r : 4 * r + k]; };
  const double z = at(2, 2) * -distance + at(2, 3), w = at(3, 2) * -distance + at(3, 3);
  const double ndc = z / w;
  return static_cast<float>(v.depth_range == BCCSPLAT_DEPTH_RANGE_MINUS_ONE_ONE ? (ndc + 1) / 2 : ndc);
}

TEST_F(Views, MatricesOfEveryConventionAreTheCamera) {
  for (const bool perspective : {false, true}) {
    const bccsplat_camera c = camera(perspective);
    const bccsplat_view by_camera = view_of(c);
    const Pixels expected = draw(&by_camera);
    for (const Convention& by : conventions) {
      const bccsplat_view v = matrix_view(c, by, 1, 200);
      EXPECT_LT(largest_difference(draw(&v), expected), 2e-5) << perspective << ' ' << by.range << by.y_down;
    }
  }
}

TEST_F(Views, LeftHandedMatricesAreTheCamera) {
  const bccsplat_camera c = camera(true);
  const bccsplat_view by_camera = view_of(c);
  const Pixels expected = draw(&by_camera);
  bccsplat_view v = matrix_view(c, conventions[0], 1, 200);
  // z of view space points away from the eye instead of towards it.
  for (size_t k = 0; k < 4; ++k) v.world_to_view[8 + k] *= -1, v.projection[4 * k + 2] *= -1;
  EXPECT_LT(largest_difference(draw(&v), expected), 2e-5);
}

TEST_F(Views, PartsOfAPictureAreThePicture) {
  for (const bool perspective : {false, true})
    for (const double magnified : {1.0, 3.0}) {
      bccsplat_camera c = camera(perspective);
      c.ortho_height /= magnified, c.fovy_degrees /= magnified;
      bccsplat_view v = view_of(c);
      const Pixels whole = draw(&v);
      v.picture_size[0] = width, v.picture_size[1] = height;
      for (const auto& [x, y, w, h] : {std::array<uint32_t, 4>{0, 0, 40, 17}, {31, 20, 41, 28}}) {
        v.region_begin[0] = x, v.region_begin[1] = y;
        const Pixels part = draw(&v, w, h);
        double off = 0;
        for (uint32_t j = 0; j < h; ++j)
          for (uint32_t i = 0; i < 4 * w; ++i)
            off = larger(
                off, std::fabs(part[4 * size_t{w} * j + i] - whole[4 * (size_t{width} * (j + y) + x) + i]));
        EXPECT_LT(off, 2e-5) << perspective << ' ' << magnified;
      }
    }
}

// An off-axis frustum: the middle of a wider picture.
TEST_F(Views, OffAxisMatricesAreAPartOfAPicture) {
  const bccsplat_camera c = camera(true);
  bccsplat_view part = view_of(c);
  part.picture_size[0] = 2 * width, part.picture_size[1] = height;
  part.region_begin[0] = 50, part.region_begin[1] = 0;
  const Pixels expected = draw(&part);
  bccsplat_view v = matrix_view(c, conventions[0], 1, 200);
  // x of the wide picture runs over [-2, 2] of this one's: take [50, 50 + width) of its 2 width pixels.
  const double middle = (2 * (50 + width / 2.0) / (2 * width) - 1) * 2;
  for (size_t k = 0; k < 4; ++k) v.projection[k] -= middle * v.projection[12 + k];
  EXPECT_LT(largest_difference(draw(&v), expected), 2e-5);
}

TEST_F(Views, DepthsFarAwayChangeNothing) {
  for (const bool perspective : {false, true}) {
    const bccsplat_camera c = camera(perspective);
    bccsplat_view v = view_of(c);
    const Pixels expected = draw(&v);
    const Pixels none(size_t{width} * height, infinite), missing(none.size(), NAN);
    v.depth = none.data();
    EXPECT_EQ(draw(&v), expected);
    v.depth = missing.data();
    EXPECT_EQ(draw(&v), expected);
  }
}

// Before and behind a plane that faces the camera: what both pass is what the whole passes.
TEST_F(Views, HalvesBeforeAndBehindADepthAddUp) {
  for (const bool perspective : {false, true}) {
    const bccsplat_camera c = camera(perspective);
    bccsplat_view v = view_of(c);
    const Pixels whole = draw(&v);
    const float middle = distance_to_target(c);
    const Pixels plane(size_t{width} * height, middle);
    v.depth = plane.data();
    const Pixels before = draw(&v);
    v.depth = nullptr;
    clip({behind(c, middle)});
    const Pixels rest = draw(&v);
    clip({});
    double off = 0, changed = 0;
    for (size_t p = 0; p < whole.size(); p += 4) {
      off = larger(off, std::fabs((1 - whole[p + 3]) - (1 - before[p + 3]) * (1 - rest[p + 3])));
      for (size_t k = 0; k < 3; ++k)
        off = larger(off, std::fabs(whole[p + k] - before[p + k] - (1 - before[p + 3]) * rest[p + k]));
      changed = larger(changed, std::fabs(whole[p + 3] - before[p + 3]));
    }
    EXPECT_LT(off, 2e-4);
    EXPECT_GT(changed, 0.05);
  }
}

TEST_F(Views, DepthsOfEveryKindEndRaysAlike) {
  for (const bool perspective : {false, true}) {
    const bccsplat_camera c = camera(perspective);
    bccsplat_view v = view_of(c);
    const float middle = distance_to_target(c);
    // A slope across the picture, and nothing in its corner.
    Pixels planar(size_t{width} * height);
    for (size_t p = 0; p < planar.size(); ++p)
      planar[p] = p % width < 8 ? infinite : middle + 0.1f * (static_cast<float>(p % width) - 36);
    v.depth = planar.data();
    const Pixels expected = draw(&v);
    Pixels along(planar.size());
    for (size_t p = 0; p < along.size(); ++p) {
      const double pixel[3] = {column(p) + 0.5, row_of(p) + 0.5, 1};
      double at[3], square = 0;
      ASSERT_OK(bccsplat_view_unproject(&v, width, height, 1, pixel, at));
      for (size_t a = 0; a < 3; ++a) square += (at[a] - c.position[a]) * (at[a] - c.position[a]);
      along[p] = perspective ? static_cast<float>(planar[p] * std::sqrt(square)) : planar[p];
    }
    v.depth = along.data(), v.depth_kind = BCCSPLAT_DEPTH_RAY;
    EXPECT_LT(largest_difference(draw(&v), expected), 1e-4);
    for (const Convention& by : conventions) {
      bccsplat_view m = matrix_view(c, by, 1, 200);
      // From the bottom row up, with a gap between rows.
      constexpr size_t row = width + 5;
      Pixels device(row * height);
      for (size_t p = 0; p < planar.size(); ++p) {
        const float far_end = by.range == BCCSPLAT_DEPTH_RANGE_REVERSED ? 0.0f : 1.0f;
        device[(height - 1 - p / width) * row + p % width] =
            std::isfinite(planar[p]) ? device_depth_of(m, planar[p]) : far_end;
      }
      m.depth = device.data() + row * (height - 1);
      m.depth_row_bytes = -static_cast<int64_t>(row * sizeof(float));
      EXPECT_LT(largest_difference(draw(&m), expected), 5e-4) << perspective << ' ' << by.range;
    }
  }
}

TEST_F(Views, TheBackgroundShowsThrough) {
  const bccsplat_camera c = camera(false);
  bccsplat_view v = view_of(c);
  const Pixels own = draw(&v);
  Pixels below(own.size());
  for (size_t p = 0; p < below.size(); ++p) below[p] = static_cast<float>(p % 7) / 8;
  v.background = below.data();
  const Pixels both = draw(&v);
  for (size_t p = 0; p < own.size(); ++p)
    ASSERT_NEAR(both[p], own[p] + (1 - own[p / 4 * 4 + 3]) * below[p], 1e-6);
}

TEST_F(Views, ClipsTakeAwayAndNothingElse) {
  set_shading(BCCSPLAT_SHADING_ON);
  for (const bool perspective : {false, true}) {
    const bccsplat_camera c = camera(perspective);
    const bccsplat_view v = view_of(c);
    const Pixels whole = draw(&v);
    bccsplat_clip far_off{};
    far_off.normal[1] = 2, far_off.offset = 1e4;
    clip({far_off});
    EXPECT_EQ(draw(&v), whole);
    // A plane along the rays of a column: what is left of it stays, bit by bit.
    const auto through = [&](double x, double y, double distance) {
      const double pixel[3] = {x, y, distance};
      std::array<double, 3> p{};
      EXPECT_OK(bccsplat_view_unproject(&v, width, height, 1, pixel, p.data()));
      return p;
    };
    const auto a = through(40, 10, 20), b = through(40, 40, 20), d = through(40, 10, 60);
    bccsplat_clip left{};
    for (size_t k = 0; k < 3; ++k) {
      const size_t i = (k + 1) % 3, j = (k + 2) % 3;
      left.normal[k] = (b[i] - a[i]) * (d[j] - a[j]) - (b[j] - a[j]) * (d[i] - a[i]);
      left.offset -= left.normal[k] * a[k];
    }
    const auto beside = through(10, 10, 20);
    double side = left.offset;
    for (size_t k = 0; k < 3; ++k) side += left.normal[k] * beside[k];
    if (side < 0)
      for (double* n : {&left.normal[0], &left.normal[1], &left.normal[2], &left.offset}) *n = -*n;
    clip({left});
    const Pixels half = draw(&v);
    for (size_t p = 0; p < whole.size(); ++p)
      ASSERT_EQ(half[p], p / 4 % width < 40 ? whole[p] : 0.0f) << p / 4 % width;
    // What lies on either side of two faces that exclude each other is nothing.
    bccsplat_clip right = left;
    for (double* n : {&right.normal[0], &right.normal[1], &right.normal[2], &right.offset}) *n = -*n;
    right.offset -= 1;
    clip({left, right});
    for (const float p : draw(&v)) ASSERT_EQ(p, 0.0f);
    clip({});
  }
}

TEST_F(Views, EveryModeIsCut) {
  for (const bool perspective : {false, true}) {
    const bccsplat_camera c = camera(perspective);
    bccsplat_view v = view_of(c);
    const float middle = distance_to_target(c) - 2;
    const Pixels plane(size_t{width} * height, middle);
    struct Parts {
      Pixels whole, before, behind, before_depth, behind_depth;
    };
    const auto parts = [&] {
      Parts p;
      v.depth = nullptr;
      p.whole = draw(&v);
      v.depth = plane.data();
      p.before = draw(&v), p.before_depth = depth_;
      v.depth = nullptr;
      clip({behind(c, middle)});
      p.behind = draw(&v), p.behind_depth = depth_;
      clip({});
      return p;
    };
    auto o = sized<bccsplat_render_options>();
    o.mode = BCCSPLAT_MODE_XRAY;
    ASSERT_OK(bccsplat_renderer_set_options(renderer_.get(), &o));
    Parts p = parts();
    double largest = 0;
    for (size_t i = 0; i < p.whole.size(); i += 4) {
      ASSERT_NEAR(p.before[i] + p.behind[i], p.whole[i], 1e-3 * (1 + std::fabs(p.whole[i])));
      largest = larger(largest, std::min(p.before[i], p.behind[i]));
    }
    EXPECT_GT(largest, 100) << "both have a part of it";
    o.mode = BCCSPLAT_MODE_MAXIMUM;
    ASSERT_OK(bccsplat_renderer_set_options(renderer_.get(), &o));
    p = parts();
    for (size_t i = 0; i < p.whole.size(); i += 4)
      ASSERT_NEAR(std::max(p.before[i + 3], p.behind[i + 3]), p.whole[i + 3], 0.02);
    o.mode = BCCSPLAT_MODE_ISOSURFACE, o.set_mask = BCCSPLAT_RENDER_SET_ISO, o.iso_value = 60;
    o.smooth_edges = BCCSPLAT_SMOOTH_EDGES_OFF;
    ASSERT_OK(bccsplat_renderer_set_options(renderer_.get(), &o));
    p = parts();
    int near = 0, far = 0;
    for (size_t i = 0; i < plane.size(); ++i) {
      if (std::isfinite(p.before_depth[i])) {
        ASSERT_LE(p.before_depth[i], middle + 1e-3);
        // Where there is a front, it is what the whole picture shows.
        ASSERT_NEAR(p.before[4 * i], p.whole[4 * i], 1e-5);
        ++near;
      }
      if (std::isfinite(p.behind_depth[i])) {
        ASSERT_GE(p.behind_depth[i], middle - 1e-3);
        ++far;
      }
    }
    EXPECT_GT(near, 20);
    EXPECT_GT(far, 20);
  }
}

TEST_F(Views, TrailsAreCutAsTheirSlicesAre) {
  auto trail = sized<bccsplat_trail>();
  trail.interval[0] = -2, trail.interval[1] = 2;
  ASSERT_OK(bccsplat_renderer_set_trail(renderer_.get(), &trail));
  const bccsplat_camera c = camera(true);
  bccsplat_view v = view_of(c);
  const Pixels whole = draw(&v);
  const Pixels plane(size_t{width} * height, distance_to_target(c));
  v.depth = plane.data();
  const Pixels before = draw(&v);
  v.depth = nullptr;
  clip({behind(c, distance_to_target(c))});
  const Pixels rest = draw(&v);
  clip({behind(c, 1e4)});
  for (const float p : draw(&v)) ASSERT_EQ(p, 0.0f);
  double off = 0, least = 1;
  for (size_t i = 3; i < whole.size(); i += 4) {
    off = larger(off, std::fabs((1 - whole[i]) - (1 - before[i]) * (1 - rest[i])));
    least = std::min<double>(least, 1 - std::min(before[i], rest[i]));
  }
  EXPECT_LT(off, 2e-4);
  EXPECT_LT(least, 0.95);
}

// Sheets beside the slow integration of the same field, with a slope of depths and two faces.
TEST_F(Views, TheReferenceCutsAlike) {
  set_shading(BCCSPLAT_SHADING_ON);
  const bccsplat_camera c = camera(true);
  bccsplat_view v = view_of(c);
  Pixels slope(size_t{width} * height);
  for (size_t p = 0; p < slope.size(); ++p)
    slope[p] = distance_to_target(c) + 0.15f * static_cast<float>(column(p) - 36);
  v.depth = slope.data();
  bccsplat_clip top{};
  top.normal[1] = -1, top.normal[0] = 0.2, top.offset = 6;
  clip({behind(c, distance_to_target(c) - 5), top});
  const auto by = [&](int32_t reference) {
    auto o = sized<bccsplat_render_options>();
    o.quality = BCCSPLAT_QUALITY_BEST, o.reference = reference;
    EXPECT_OK(bccsplat_renderer_set_options(renderer_.get(), &o));
    return draw(&v);
  };
  const Pixels sheets = by(0), truth = by(1);
  double squares = 0;
  float largest = 0;
  for (size_t p = 0; p < truth.size(); ++p)
    squares += std::pow(sheets[p] - truth[p], 2), largest = std::max(largest, truth[p]);
  ASSERT_GT(largest, 0.2);
  const double decibels = 10 * std::log10(largest * largest * static_cast<double>(truth.size()) / squares);
  EXPECT_GT(decibels, 45);
}

// The edges of a box by the matrices, and those of the picture of it.
TEST_F(Views, AWireframeFits) {
  opacities_[0] = -10, opacities_[1] = 1, opacities_[2] = 90, opacities_[3] = 1;
  auto f = sized<bccsplat_transfer_function>();
  f.colors = colors_, f.color_count = 2, f.opacities = opacities_, f.opacity_count = 2;
  f.unit_distance = 1e-3; // opaque where it begins
  ASSERT_OK(bccsplat_renderer_set_transfer_function(renderer_.get(), &f));
  constexpr std::array<double, 16> box{6, 1, 0, 8, -1, 7, 2, 0, 0, 1, 9, 8, 0, 0, 0, 1};
  std::vector<bccsplat_clip> faces(6);
  ASSERT_OK(bccsplat_make_box_clips(box.data(), faces.data()));
  clip(faces);
  for (const bool perspective : {false, true})
    for (const Convention& by : conventions) {
      const bccsplat_view v = matrix_view(camera(perspective), by, 1, 200);
      const Pixels picture = draw(&v);
      double seen[4] = {1e9, 1e9, -1e9, -1e9}, drawn[4] = {1e9, 1e9, -1e9, -1e9};
      const auto widen = [](double(&r)[4], double x, double y) {
        r[0] = std::min(r[0], x), r[1] = std::min(r[1], y), r[2] = larger(r[2], x), r[3] = larger(r[3], y);
      };
      for (size_t p = 0; p < picture.size() / 4; ++p)
        if (picture[4 * p + 3] > 0.5) widen(seen, column(p) + 0.5, row_of(p) + 0.5);
      for (size_t n = 0; n < 8; ++n) {
        double corner[3], pixel[3];
        for (size_t r = 0; r < 3; ++r)
          corner[r] = box[4 * r + 3] + (n & 1 ? box[4 * r] : 0) + (n & 2 ? box[4 * r + 1] : 0) +
                      (n & 4 ? box[4 * r + 2] : 0);
        ASSERT_OK(bccsplat_view_project(&v, width, height, 1, corner, pixel));
        widen(drawn, pixel[0], pixel[1]);
        double back[3];
        ASSERT_OK(bccsplat_view_unproject(&v, width, height, 1, pixel, back));
        for (size_t a = 0; a < 3; ++a) ASSERT_NEAR(back[a], corner[a], 1e-9);
      }
      // Corners are sharp: the last pixel centre inside may be more than half a pixel from one, along an
      // edge.
      for (size_t k = 0; k < 4; ++k) EXPECT_NEAR(seen[k], drawn[k], 1.0) << k;
      for (size_t k = 0; k < 2; ++k) {
        EXPECT_GE(seen[k], drawn[k] - 1e-6) << "outside";
        EXPECT_LE(seen[k + 2], drawn[k + 2] + 1e-6) << "outside";
      }
    }
}

TEST_F(Views, NeedsAreThoseOfWhatClipsLeave) {
  const bccsplat_camera c = camera(false);
  const bccsplat_view v = view_of(c);
  auto by_camera = sized<bccsplat_picture_needs>(), by_view = by_camera, clipped = by_camera;
  ASSERT_OK(bccsplat_slice_get_picture_needs(slice_.get(), &c, width, height, nullptr, &by_camera));
  ASSERT_OK(bccsplat_slice_get_view_needs(slice_.get(), &v, nullptr, 0, width, height, nullptr, &by_view));
  for (size_t n = 0; n < 6; ++n) EXPECT_NEAR(by_view.box[n], by_camera.box[n], 1e-9);
  EXPECT_EQ(by_view.level, by_camera.level);
  bccsplat_clip half{}; // world z is mostly along z
  half.normal[2] = 1, half.offset = -(3 + 1.5 * 12);
  ASSERT_OK(bccsplat_slice_get_view_needs(slice_.get(), &v, &half, 1, width, height, nullptr, &clipped));
  EXPECT_GT(clipped.box[2], 8);
  EXPECT_LT(clipped.box[2], 12);
  half.offset = -1000;
  ASSERT_OK(bccsplat_slice_get_view_needs(slice_.get(), &v, &half, 1, width, height, nullptr, &clipped));
  EXPECT_EQ(clipped.seen, 0);
}

TEST_F(Views, NonsenseIsRefused) {
  const bccsplat_camera c = camera(true);
  const auto refused = [&](const bccsplat_view& v) {
    return bccsplat_renderer_set_view(renderer_.get(), &v) == BCCSPLAT_ERROR_INVALID_ARGUMENT;
  };
  bccsplat_view v = matrix_view(c, conventions[0], 1, 200);
  EXPECT_OK(bccsplat_renderer_set_view(renderer_.get(), &v));
  v.camera = &c;
  EXPECT_TRUE(refused(v)) << "both";
  v = matrix_view(c, conventions[0], 1, 200);
  std::fill(std::begin(v.projection), std::end(v.projection), 0.0);
  EXPECT_TRUE(refused(v)) << "no projection";
  v = matrix_view(c, conventions[0], 1, 200);
  for (size_t k = 0; k < 4; ++k) v.world_to_view[k] = v.world_to_view[4 + k];
  EXPECT_TRUE(refused(v)) << "singular";
  v = matrix_view(c, conventions[0], 1, 200);
  v.projection[3] = NAN;
  EXPECT_TRUE(refused(v)) << "not a number";
  v = view_of(c);
  const float depth = 1;
  v.depth = &depth, v.depth_kind = BCCSPLAT_DEPTH_DEVICE;
  EXPECT_TRUE(refused(v)) << "device depth of a camera";
  v.depth_kind = 4;
  EXPECT_TRUE(refused(v)) << "kind";
  v = view_of(c);
  v.depth = &depth, v.depth_row_bytes = 6;
  EXPECT_TRUE(refused(v)) << "rows";
  v = view_of(c);
  v.region_begin[0] = 3;
  EXPECT_TRUE(refused(v)) << "a part of nothing";
  v = view_of(c);
  v.picture_size[0] = width, v.picture_size[1] = height, v.region_begin[0] = 10;
  ASSERT_OK(bccsplat_renderer_set_view(renderer_.get(), &v));
  bccsplat_frame* created = nullptr;
  ASSERT_OK(bccsplat_frame_create(device_.get(), width, height, 0, &created));
  const Frame frame(created);
  EXPECT_EQ(bccsplat_renderer_render(renderer_.get(), created), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  bccsplat_clip none{};
  EXPECT_EQ(bccsplat_renderer_set_clips(renderer_.get(), &none, 1), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  none.normal[0] = 1, none.instance = 1;
  EXPECT_EQ(bccsplat_renderer_set_clips(renderer_.get(), &none, 1), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  const std::vector<bccsplat_clip> many(33, bccsplat_clip{{1, 0, 0}, 0, 0, 0, 0});
  EXPECT_EQ(bccsplat_renderer_set_clips(renderer_.get(), many.data(), 33), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  double matrix[16];
  EXPECT_EQ(bccsplat_camera_get_matrices(&c, 8, 8, 5, 2, 0, 0, matrix, matrix),
            BCCSPLAT_ERROR_INVALID_ARGUMENT);
  const double flat[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1};
  bccsplat_clip faces[6];
  EXPECT_EQ(bccsplat_make_box_clips(flat, faces), BCCSPLAT_ERROR_INVALID_ARGUMENT);
}

} // namespace
