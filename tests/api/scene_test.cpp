// SPDX-License-Identifier: Apache-2.0
// Volumes in a host's scene: one instance is a renderer's picture, several are right in depth, time and place
// are as they are set, and a budget ends in the picture.
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <string>
#include <thread>
#include <vector>

#include "host_streams.h"
#include "support.h"

using namespace host;

namespace {

using Scene = Handle<bccsplat_scene>;
using Pixels = std::vector<float>; // 4 per pixel
constexpr uint32_t scene_width = 80, scene_height = 64;

class Scenes : public testing::Test {
 protected:
  void SetUp() override {
    device_ = make_device();
    Series s;
    s.nx = s.ny = s.nz = 40, s.first = 10, s.step = 2;
    s.field = [](double x, double y, double z, double t) {
      const double dx = x - 14 - t, dy = y - 18, dz = z - 20 + t / 2;
      return 100 * std::exp(-(dx * dx + dy * dy + dz * dz) / 50);
    };
    auto o = options_of(s);
    o.levels = 1;
    const Writer writer = make_writer(device_, folder_.file("s.bcc4"), o);
    ASSERT_OK(add_frames(writer.get(), s));
    ASSERT_OK(bccsplat_writer_finish(writer.get(), nullptr));
    volume_ = open(device_, folder_.file("s.bcc4"));
    scene_ = make_scene();
    function_.colors = colors_, function_.color_count = 2;
    function_.opacities = opacities_, function_.opacity_count = 2;
    function_.unit_distance = 1;
  }
  [[nodiscard]] Scene make_scene() const {
    bccsplat_scene* s = nullptr;
    EXPECT_OK(bccsplat_scene_create(device_.get(), &s));
    return Scene(s);
  }
  [[nodiscard]] bccsplat_instance instance() const {
    auto i = sized<bccsplat_instance>();
    i.transfer_function = &function_;
    return i;
  }
  uint64_t add(const bccsplat_instance& i, const Scene* to = nullptr) const {
    uint64_t id = 0;
    EXPECT_OK(bccsplat_scene_add((to ? *to : scene_).get(), volume_.get(), &i, &id));
    return id;
  }
  // Looks at the whole volume, whatever else the scene holds.
  [[nodiscard]] bccsplat_camera camera(bool perspective = true) const {
    auto c = sized<bccsplat_camera>();
    EXPECT_OK(bccsplat_slice_fit_camera(cut_time(volume_, 3).get(),
                                        perspective ? BCCSPLAT_PROJECTION_PERSPECTIVE
                                                    : BCCSPLAT_PROJECTION_ORTHOGRAPHIC,
                                        20, 35, scene_width, scene_height, &c));
    return c;
  }
  [[nodiscard]] Frame frame(uint32_t channels = 0) const {
    bccsplat_frame* f = nullptr;
    EXPECT_OK(bccsplat_frame_create(device_.get(), scene_width, scene_height, channels, &f));
    return Frame(f);
  }
  [[nodiscard]] static Pixels pixels(const Frame& f) {
    auto plane = sized<bccsplat_plane>();
    EXPECT_OK(bccsplat_frame_get_channel(f.get(), BCCSPLAT_FRAME_RGBA, &plane));
    return {plane.pixels, plane.pixels + size_t{4} * scene_width * scene_height};
  }
  [[nodiscard]] Pixels draw(const bccsplat_camera& c, const bccsplat_render_options* options = nullptr,
                            const Scene* of = nullptr) {
    auto v = sized<bccsplat_view>();
    v.camera = &c;
    const Frame f = frame(BCCSPLAT_FRAME_DEPTH);
    status_ = sized<bccsplat_scene_status>();
    EXPECT_OK(bccsplat_scene_render((of ? *of : scene_).get(), &v, f.get(), options, 0, &status_));
    EXPECT_EQ(status_.complete, 1u);
    EXPECT_EQ(status_.progress, 1);
    return pixels(f);
  }
  void set_time(double t) { ASSERT_OK(bccsplat_scene_set_time(scene_.get(), t)); }

  const Folder folder_;
  Device device_;
  Volume volume_;
  Scene scene_;
  bccsplat_scene_status status_{};
  bccsplat_transfer_function function_ = sized<bccsplat_transfer_function>();
  double colors_[8] = {10, 1, 0.2, 0.1, 100, 0.2, 0.9, 1};
  double opacities_[4] = {5, 0, 90, 0.25};
};

float sum_of(const Pixels& p) {
  float sum = 0;
  for (size_t n = 3; n < p.size(); n += 4) sum += p[n];
  return sum;
}

void place(bccsplat_instance& i, const std::array<double, 12>& rows) {
  std::copy(rows.begin(), rows.end(), i.placement), i.placement[15] = 1;
}

TEST_F(Scenes, OneInstanceIsTheRenderersPicture) {
  (void)add(instance());
  set_time(10 + 2 * 3.25);
  bccsplat_renderer* created = nullptr;
  ASSERT_OK(bccsplat_renderer_create(device_.get(), &created));
  const Renderer renderer(created);
  const Slice slice = cut_time(volume_, 3.25);
  ASSERT_OK(bccsplat_renderer_set_slice(created, slice.get()));
  ASSERT_OK(bccsplat_renderer_set_transfer_function(created, &function_));
  auto options = sized<bccsplat_render_options>();
  options.quality = BCCSPLAT_QUALITY_FINE; // of level 0
  ASSERT_OK(bccsplat_renderer_set_options(created, &options));
  for (const bool perspective : {false, true}) {
    const bccsplat_camera c = camera(perspective);
    ASSERT_OK(bccsplat_renderer_set_camera(created, &c));
    const Frame f = frame();
    ASSERT_OK(bccsplat_renderer_render(created, f.get()));
    EXPECT_EQ(draw(c, &options), pixels(f));
    EXPECT_EQ(status_.drawn, 1u);
    EXPECT_EQ(status_.level, 0u);
  }
  EXPECT_EQ(status_.cut, 0u) << "the slice was there";
}

// The default view is the same, too, also of volumes of a few samples and turned in the world.
TEST_F(Scenes, OneInstanceHasTheRenderersDefaultView) {
  constexpr std::array<std::array<uint32_t, 3>, 6> shapes{
      {{1, 1, 1}, {2, 1, 1}, {2, 1, 2}, {8, 8, 1}, {1, 5, 1}, {4, 3, 2}}};
  for (const auto& [nx, ny, nz] : shapes)
    for (const double turn : {0.0, 0.6}) {
      SCOPED_TRACE(std::to_string(nx) + " " + std::to_string(ny) + " " + std::to_string(nz) + ", turned by " +
                   std::to_string(turn));
      Series s{.nx = nx, .ny = ny, .nz = nz, .nt = 6};
      s.field = [](double x, double y, double z, double t) { return 60 + 30 * std::sin(x + y + z + t); };
      auto o = options_of(s);
      const std::array<double, 16> affine{std::cos(turn),
                                          -std::sin(turn),
                                          0,
                                          3,
                                          std::sin(turn),
                                          std::cos(turn),
                                          0,
                                          0,
                                          0,
                                          0,
                                          2,
                                          -7,
                                          0,
                                          0,
                                          0,
                                          1};
      std::copy(affine.begin(), affine.end(), o.affine);
      const std::string path = folder_.free_file("f.bcc4");
      {
        const Writer w = make_writer(device_, path, o);
        ASSERT_OK(add_frames(w.get(), s));
        ASSERT_OK(bccsplat_writer_finish(w.get(), nullptr));
      }
      const Volume few = open(device_, path);
      const Slice slice = cut_time(few, 3.25);
      const Scene scene = make_scene();
      const auto i = instance();
      uint64_t id = 0;
      ASSERT_OK(bccsplat_scene_add(scene.get(), few.get(), &i, &id));
      ASSERT_OK(bccsplat_scene_set_time(scene.get(), 3.25));
      auto of_scene = sized<bccsplat_camera>(), of_slice = sized<bccsplat_camera>();
      ASSERT_OK(bccsplat_scene_fit_camera(scene.get(), 0, 20, 30, scene_width, scene_height, &of_scene));
      ASSERT_OK(bccsplat_slice_fit_camera(slice.get(), 0, 20, 30, scene_width, scene_height, &of_slice));
      EXPECT_NEAR(of_scene.ortho_height, of_slice.ortho_height, 1e-9);
      for (size_t a = 0; a < 3; ++a) EXPECT_NEAR(of_scene.position[a], of_slice.position[a], 1e-9) << a;

      bccsplat_renderer* created = nullptr;
      ASSERT_OK(bccsplat_renderer_create(device_.get(), &created));
      const Renderer renderer(created);
      ASSERT_OK(bccsplat_renderer_set_slice(created, slice.get()));
      ASSERT_OK(bccsplat_renderer_set_transfer_function(created, &function_));
      const Frame by_renderer = frame(), by_scene = frame();
      ASSERT_OK(bccsplat_renderer_render(created, by_renderer.get()));
      ASSERT_OK(bccsplat_scene_render(scene.get(), nullptr, by_scene.get(), nullptr, 0, nullptr));
      const Pixels drawn = pixels(by_renderer);
      EXPECT_LT(largest_difference(drawn, pixels(by_scene)), 1e-5);
      EXPECT_GT(sum_of(drawn), 10);
    }
}

TEST_F(Scenes, NothingIsDrawnOfNothing) {
  const bccsplat_camera c = camera();
  EXPECT_EQ(sum_of(draw(c)), 0);
  auto v = sized<bccsplat_view>();
  const Frame f = frame();
  EXPECT_EQ(bccsplat_scene_render(scene_.get(), &v, f.get(), nullptr, 0, nullptr), BCCSPLAT_ERROR_WRONG_STATE)
      << "there is no default view of nothing";
  auto i = instance();
  i.hidden = 1;
  const uint64_t id = add(i);
  set_time(15);
  EXPECT_EQ(sum_of(draw(c)), 0);
  i.hidden = 0;
  ASSERT_OK(bccsplat_scene_set_instance(scene_.get(), id, &i));
  EXPECT_GT(sum_of(draw(c)), 10);
  ASSERT_OK(bccsplat_scene_remove(scene_.get(), id));
  EXPECT_EQ(sum_of(draw(c)), 0);
  EXPECT_EQ(bccsplat_scene_remove(scene_.get(), id), BCCSPLAT_ERROR_NOT_FOUND);
  EXPECT_EQ(bccsplat_scene_set_instance(scene_.get(), id, &i), BCCSPLAT_ERROR_NOT_FOUND);
}

TEST_F(Scenes, APlacedVolumeSeenByAPlacedCameraIsTheVolume) {
  const uint64_t id = add(instance());
  set_time(15);
  const bccsplat_camera c = camera();
  auto fine = sized<bccsplat_render_options>();
  fine.quality = BCCSPLAT_QUALITY_FINE;
  const Pixels own = draw(c, &fine);
  // Turned by 90 degrees about z, twice as large, and moved: the camera likewise.
  auto moved = instance();
  place(moved, {0, -2, 0, 100, 2, 0, 0, -30, 0, 0, 2, 7});
  ASSERT_OK(bccsplat_scene_set_instance(scene_.get(), id, &moved));
  function_.unit_distance = 2;
  ASSERT_OK(bccsplat_scene_set_instance(scene_.get(), id, &moved));
  const auto turn = [](const double(&p)[3], double(&out)[3], bool point) {
    out[0] = -2 * p[1] + (point ? 100 : 0), out[1] = 2 * p[0] - (point ? 30 : 0),
    out[2] = 2 * p[2] + (point ? 7 : 0);
  };
  auto there = sized<bccsplat_camera>();
  there.projection = c.projection, there.fovy_degrees = c.fovy_degrees;
  turn(c.position, there.position, true), turn(c.target, there.target, true), turn(c.up, there.up, false);
  EXPECT_LT(largest_difference(draw(there, &fine), own), 1e-4);
  EXPECT_EQ(status_.cut, 0u) << "a volume that moves is not cut anew";
  double bounds[6];
  ASSERT_OK(bccsplat_scene_get_bounds(scene_.get(), bounds));
  const double expected[6] = {100 - 78, -30, 7, 100, -30 + 78, 7 + 78};
  for (size_t n = 0; n < 6; ++n) EXPECT_NEAR(bounds[n], expected[n], 1e-9) << n;
  auto fitted = sized<bccsplat_camera>();
  ASSERT_OK(bccsplat_scene_fit_camera(scene_.get(), 0, 0, 0, scene_width, scene_height, &fitted));
  EXPECT_NEAR(fitted.target[0], 61, 1e-9);
}

// Small pictures are of coarser slices, which go where the volume goes.
TEST_F(Scenes, WhatIsFarAwayMovesAsWell) {
  auto c = sized<bccsplat_camera>();
  c.projection = BCCSPLAT_PROJECTION_ORTHOGRAPHIC, c.ortho_height = 250;
  c.position[2] = -300, c.up[1] = 1;
  auto moved = instance();
  place(moved, {0, -1, 0, 30, 1, 0, 0, -25, 0, 0, 1, 0});
  const uint64_t id = add(instance());
  set_time(15);
  const Pixels before = draw(c);
  ASSERT_OK(bccsplat_scene_set_instance(scene_.get(), id, &moved));
  const Scene fresh = make_scene();
  (void)add(moved, &fresh);
  ASSERT_OK(bccsplat_scene_set_time(fresh.get(), 15));
  const Pixels after = draw(c);
  EXPECT_EQ(after, draw(c, nullptr, &fresh));
  EXPECT_NE(after, before);
}

TEST_F(Scenes, AMirrorImageIsOne) {
  const uint64_t id = add(instance());
  set_time(15);
  auto c = sized<bccsplat_camera>();
  c.projection = BCCSPLAT_PROJECTION_ORTHOGRAPHIC, c.ortho_height = 60;
  c.position[0] = c.position[1] = c.target[0] = c.target[1] = 19.5, c.position[2] = -50, c.up[1] = 1;
  auto fine = sized<bccsplat_render_options>();
  fine.quality = BCCSPLAT_QUALITY_FINE;
  const Pixels own = draw(c, &fine);
  auto mirrored = instance();
  place(mirrored, {-1, 0, 0, 39, 0, 1, 0, 0, 0, 0, 1, 0}); // about x = 19.5, the middle of the picture
  ASSERT_OK(bccsplat_scene_set_instance(scene_.get(), id, &mirrored));
  const Pixels mirror = draw(c, &fine);
  double off = 0, other = 0;
  for (size_t y = 0; y < scene_height; ++y)
    for (size_t x = 0; x < scene_width; ++x)
      for (size_t k = 0; k < 4; ++k) {
        off = larger(off, std::fabs(mirror[4 * (scene_width * y + x) + k] -
                                    own[4 * (scene_width * y + scene_width - 1 - x) + k]));
        other = larger(other,
                       std::fabs(mirror[4 * (scene_width * y + x) + k] - own[4 * (scene_width * y + x) + k]));
      }
  EXPECT_LT(off, 2e-3); // sites stand elsewhere in the pixels
  EXPECT_GT(other, 0.1);
}

TEST_F(Scenes, TimeIsScaledAndGoesOnAsAsked) {
  auto i = instance();
  const uint64_t id = add(i);
  const bccsplat_camera c = camera();
  set_time(15);
  const Pixels at_15 = draw(c);
  set_time(24);
  const Pixels last = draw(c);
  EXPECT_NE(last, at_15);
  set_time(24.5);
  EXPECT_EQ(sum_of(draw(c)), 0) << "hidden outside the series";
  i.outside = BCCSPLAT_OUTSIDE_HOLD;
  ASSERT_OK(bccsplat_scene_set_instance(scene_.get(), id, &i));
  EXPECT_EQ(draw(c), last);
  i.outside = BCCSPLAT_OUTSIDE_LOOP; // 14 long
  ASSERT_OK(bccsplat_scene_set_instance(scene_.get(), id, &i));
  for (const double t : {15.0 + 14, 15.0 - 28}) {
    set_time(t);
    EXPECT_EQ(draw(c), at_15) << t;
  }
  i.outside = BCCSPLAT_OUTSIDE_HIDE, i.time_scale = 0.5, i.time_offset = 10;
  ASSERT_OK(bccsplat_scene_set_instance(scene_.get(), id, &i));
  set_time(10);
  EXPECT_EQ(draw(c), at_15);
}

TEST_F(Scenes, TwoHalvesInOnePlaceAreTheVolume) {
  auto options = sized<bccsplat_render_options>();
  options.opacity_stop = 1;
  (void)add(instance());
  set_time(15);
  const bccsplat_camera c = camera();
  const Pixels whole = draw(c, &options);
  const Scene two = make_scene();
  auto half = instance();
  half.density = 0.5;
  (void)add(half, &two), (void)add(half, &two);
  ASSERT_OK(bccsplat_scene_set_time(two.get(), 15));
  EXPECT_LT(largest_difference(draw(c, &options, &two), whole), 4e-3);
  EXPECT_EQ(status_.drawn, 2u);
}

// One behind the other, whichever was added first: as one picture over the other.
TEST_F(Scenes, InstancesAreRightInDepth) {
  auto options = sized<bccsplat_render_options>();
  options.opacity_stop = 1, options.shading = BCCSPLAT_SHADING_OFF;
  auto c = sized<bccsplat_camera>();
  c.projection = BCCSPLAT_PROJECTION_ORTHOGRAPHIC, c.ortho_height = 60;
  c.position[0] = c.position[1] = c.target[0] = c.target[1] = 19.5, c.position[2] = -200, c.up[1] = 1;
  auto near = instance(), far = instance();
  place(near, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, -60});
  place(far, {1, 0, 0, 4, 0, 1, 0, 3, 0, 0, 1, 60});
  near.time_offset = -3;
  const auto alone = [&](const bccsplat_instance& i) {
    const Scene s = make_scene();
    (void)add(i, &s);
    EXPECT_OK(bccsplat_scene_set_time(s.get(), 16));
    return draw(c, &options, &s);
  };
  const Pixels front = alone(near), back = alone(far);
  for (const bool swapped : {false, true}) {
    const Scene s = make_scene();
    (void)add(swapped ? far : near, &s), (void)add(swapped ? near : far, &s);
    ASSERT_OK(bccsplat_scene_set_time(s.get(), 16));
    const Pixels both = draw(c, &options, &s);
    double off = 0;
    for (size_t p = 0; p < both.size(); ++p)
      off = larger(off, std::fabs(both[p] - front[p] - (1 - front[p / 4 * 4 + 3]) * back[p]));
    EXPECT_LT(off, 4e-3);
  }
}

// Magnified, sheets are raised from fewer samples, each instance's by tables of its own: as one picture over
// the other, too, where the ranges of their sheets are apart.
TEST_F(Scenes, MagnifiedInstancesAreRightInDepth) {
  auto options = sized<bccsplat_render_options>();
  options.opacity_stop = 1;
  auto near = instance(), far = instance();
  place(near, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, -50});
  place(far, {1, 0, 0, 4, 0, 1, 0, 3, 0, 0, 1, 10});
  near.time_offset = -3;
  const auto drawn = [&](const bccsplat_camera& c, std::initializer_list<const bccsplat_instance*> all) {
    const Scene s = make_scene();
    for (const bccsplat_instance* i : all) (void)add(*i, &s);
    EXPECT_OK(bccsplat_scene_set_time(s.get(), 16));
    return draw(c, &options, &s);
  };
  for (const bool perspective : {false, true}) {
    auto c = sized<bccsplat_camera>();
    c.projection = perspective ? BCCSPLAT_PROJECTION_PERSPECTIVE : BCCSPLAT_PROJECTION_ORTHOGRAPHIC;
    c.ortho_height = 14, c.fovy_degrees = 10;
    c.position[0] = c.target[0] = 19, c.position[1] = c.target[1] = 18.5, c.position[2] = -120, c.up[1] = 1;
    for (const bccsplat_quality quality : {BCCSPLAT_QUALITY_NORMAL, BCCSPLAT_QUALITY_FINE}) {
      SCOPED_TRACE(std::to_string(quality) + (perspective ? " perspective" : ""));
      options.quality = quality;
      const Pixels front = drawn(c, {&near}), back = drawn(c, {&far});
      ASSERT_GT(sum_of(front), 500);
      ASSERT_GT(sum_of(back), 500);
      const Pixels both = drawn(c, {&far, &near});
      double off = 0;
      for (size_t p = 0; p < both.size(); ++p)
        off = larger(off, std::fabs(both[p] - front[p] - (1 - front[p / 4 * 4 + 3]) * back[p]));
      EXPECT_LT(off, 4e-3);
    }
  }
}

// What finished pixels hide is left out of each instance by the samples of its own sheets, which are others
// where the spacing is another one.
TEST_F(Scenes, NothingOpenIsLeftOutOfInstancesOfOtherSpacing) {
  double dense[4] = {5, 0, 30, 0.9};
  function_.opacities = dense;
  auto options = sized<bccsplat_render_options>();
  auto c = sized<bccsplat_camera>();
  c.projection = BCCSPLAT_PROJECTION_ORTHOGRAPHIC, c.ortho_height = 26;
  c.position[0] = c.target[0] = 19, c.position[1] = c.target[1] = 18.5, c.position[2] = -120, c.up[1] = 1;
  auto small = instance(), large = instance();
  place(small, {0.5, 0, 0, 12, 0, 0.5, 0, 10, 0, 0, 0.5, 0});
  place(large, {3, 0, 0, -33, 0, 3, 0, -36, 0, 0, 3, -20});
  for (const bool swapped : {false, true}) {
    const Scene s = make_scene();
    (void)add(swapped ? large : small, &s), (void)add(swapped ? small : large, &s);
    ASSERT_OK(bccsplat_scene_set_time(s.get(), 16));
    options.disable_skips = 0;
    const Pixels drawn = draw(c, &options, &s);
    options.disable_skips = BCCSPLAT_SKIP_OCCLUSION;
    EXPECT_GT(sum_of(drawn), 1000);
    EXPECT_EQ(largest_difference(drawn, draw(c, &options, &s)), 0) << swapped;
  }
}

// What shows of the one is the same whatever the spacing of another that hardly absorbs: sheets are then
// nearer to each other, and where that is too near deep pictures are merged.
TEST_F(Scenes, InstancesOfOtherSpacingStandInEachOther) {
  auto options = sized<bccsplat_render_options>();
  options.opacity_stop = 1, options.shading = BCCSPLAT_SHADING_OFF;
  (void)add(instance());
  set_time(15);
  const bccsplat_camera c = camera();
  const Pixels alone = draw(c, &options);
  for (const double scale : {3.0, 0.3, 0.01}) {
    const Scene s = make_scene();
    auto other = instance();
    const double at = 19.5 * (1 - scale);
    place(other, {scale, 0, 0, at, 0, scale, 0, at, 0, 0, scale, at});
    other.density = 1e-6;
    (void)add(other, &s), (void)add(instance(), &s);
    ASSERT_OK(bccsplat_scene_set_time(s.get(), 15));
    EXPECT_LT(largest_difference(draw(c, &options, &s), alone), scale > 0.1 ? 2e-3 : 4e-3) << scale;
    EXPECT_EQ(status_.drawn, 2u);
  }
}

TEST_F(Scenes, ADeepPictureOfSeveralFlattensToTheFlatOne) {
  auto other = instance();
  place(other, {1, 0, 0, 6, 0, 1, 0, 3, 0, 0, 1, -4});
  (void)add(instance()), (void)add(other);
  set_time(15);
  const bccsplat_camera c = camera();
  auto options = sized<bccsplat_render_options>();
  options.opacity_stop = 1;
  const Pixels flat = draw(c, &options);
  auto v = sized<bccsplat_view>();
  v.camera = &c;
  const Frame f = frame(BCCSPLAT_FRAME_DEEP);
  ASSERT_OK(bccsplat_scene_render(scene_.get(), &v, f.get(), &options, 0, nullptr));
  auto deep = sized<bccsplat_deep>();
  ASSERT_OK(bccsplat_frame_get_deep(f.get(), &deep));
  Pixels sums(flat.size());
  for (size_t p = 0; p < size_t{scene_width} * scene_height; ++p)
    for (uint64_t n = deep.first[p]; n < deep.first[p + 1]; ++n) {
      const float* const sample = deep.samples + 6 * n; // front, back, alpha, red, green, blue
      const float open = 1 - sums[4 * p + 3];
      for (size_t k = 0; k < 4; ++k) sums[4 * p + k] += open * sample[k == 3 ? 2 : 3 + k];
    }
  EXPECT_GT(sum_of(flat), 100);
  EXPECT_LT(largest_difference(sums, flat), 1e-5);
}

// The depth of a pixel is where the samples of its ray come to the opacity asked for.
TEST_F(Scenes, DepthsAreThoseOfAnOpacity) {
  const bccsplat_camera c = camera();
  auto v = sized<bccsplat_view>();
  v.camera = &c;
  auto dense = instance(), other = instance();
  dense.density = 5;
  place(other, {1, 0, 0, 6, 0, 1, 0, 3, 0, 0, 1, -4});
  (void)add(dense);
  set_time(15);
  auto options = sized<bccsplat_render_options>();
  options.opacity_stop = 1, options.deep_tolerance = 1e-6;
  for (int instances = 1; instances <= 2; ++instances) {
    if (instances == 2) (void)add(other);
    const Frame samples = frame(BCCSPLAT_FRAME_DEEP);
    options.depth_opacity = 0;
    ASSERT_OK(bccsplat_scene_render(scene_.get(), &v, samples.get(), &options, 0, nullptr));
    auto deep = sized<bccsplat_deep>();
    ASSERT_OK(bccsplat_frame_get_deep(samples.get(), &deep));
    for (const bool reference : {false, true})
      for (const double opacity : {1e-3, 0.05, 0.5, 0.9}) {
        if (reference && (instances == 2 || opacity < 0.01)) continue; // sheets see what is faint otherwise
        const Frame f = frame(BCCSPLAT_FRAME_DEPTH);
        options.depth_opacity = opacity, options.reference = reference;
        ASSERT_OK(bccsplat_scene_render(scene_.get(), &v, f.get(), &options, 0, nullptr));
        options.reference = 0;
        auto plane = sized<bccsplat_plane>();
        ASSERT_OK(bccsplat_frame_get_channel(f.get(), BCCSPLAT_FRAME_DEPTH, &plane));
        int there = 0;
        for (size_t p = 0; p < size_t{scene_width} * scene_height; ++p) {
          double alpha = 0, depth = HUGE_VAL;
          for (uint64_t n = deep.first[p]; n < deep.first[p + 1]; ++n) {
            const float* const s = deep.samples + 6 * n;
            const double after = alpha + (1 - alpha) * s[2];
            if (alpha < opacity && after >= opacity)
              depth = s[0] + (s[1] - s[0]) * std::log((1 - opacity) / (1 - alpha)) / std::log1p(-s[2]);
            alpha = after;
          }
          if (alpha > 0.9 * opacity && alpha < 1.1 * opacity) continue; // it may pass it or not
          const float found = plane.pixels[p];
          ASSERT_EQ(std::isinf(found), std::isinf(depth)) << p << " " << opacity;
          if (std::isinf(depth)) continue;
          ASSERT_NEAR(found, depth, reference ? 0.8 : 0.02) << p << " " << opacity << " " << reference;
          ++there;
        }
        EXPECT_GT(there, opacity > 0.8 ? 20 : 200) << opacity;
      }
  }
  options.depth_opacity = 0.9;
  const Frame both = frame(BCCSPLAT_FRAME_DEEP | BCCSPLAT_FRAME_DEPTH);
  EXPECT_EQ(bccsplat_scene_render(scene_.get(), &v, both.get(), &options, 0, nullptr),
            BCCSPLAT_ERROR_UNSUPPORTED);
}

// An EXR of a frame tells the camera of its picture: none of a picture that was cancelled on its way, and the
// one before where a picture was refused.
TEST_F(Scenes, ACancelledPictureHasNoCamera) {
  (void)add(instance());
  set_time(15);
  const bccsplat_camera c = camera();
  auto v = sized<bccsplat_view>();
  v.camera = &c;
  const Frame f = frame();
  const auto tells_camera = [&] {
    const std::string path = folder_.file("camera.exr");
    auto image = sized<bccsplat_image_options>();
    image.overwrite = 1;
    EXPECT_OK(bccsplat_frame_save_exr(f.get(), path.c_str(), &image));
    const std::vector<char> bytes = file_bytes(path);
    return std::string(bytes.begin(), bytes.end()).find("worldToCamera") != std::string::npos;
  };
  ASSERT_OK(bccsplat_scene_render(scene_.get(), &v, f.get(), nullptr, 0, nullptr));
  EXPECT_TRUE(tells_camera());
  auto wrong = sized<bccsplat_render_options>();
  wrong.mode = BCCSPLAT_MODE_ISOSURFACE;
  EXPECT_EQ(bccsplat_scene_render(scene_.get(), &v, f.get(), &wrong, 0, nullptr),
            BCCSPLAT_ERROR_INVALID_ARGUMENT);
  EXPECT_TRUE(tells_camera());
  auto stopped = sized<bccsplat_render_options>();
  stopped.progress = [](void*, double) { return 1; };
  EXPECT_EQ(bccsplat_scene_render(scene_.get(), &v, f.get(), &stopped, 0, nullptr), BCCSPLAT_CANCELLED);
  EXPECT_FALSE(tells_camera());
}

TEST_F(Scenes, ClipsCutTheInstancesTheyName) {
  auto options = sized<bccsplat_render_options>();
  options.opacity_stop = 1;
  const uint64_t first = add(instance());
  auto beside = instance();
  place(beside, {1, 0, 0, 40, 0, 1, 0, 0, 0, 0, 1, 0});
  const uint64_t second = add(beside);
  set_time(15);
  auto c = sized<bccsplat_camera>();
  c.projection = BCCSPLAT_PROJECTION_ORTHOGRAPHIC, c.ortho_height = 80;
  c.position[0] = c.target[0] = 39.5, c.position[1] = c.target[1] = 19.5, c.position[2] = -200, c.up[1] = 1;
  const Pixels whole = draw(c, &options);
  // x points to the left: instance 1 is on the right half.
  const auto half_sum = [](const Pixels& p, bool right) {
    float sum = 0;
    for (size_t n = 0; n < p.size() / 4; ++n)
      if ((n % scene_width >= scene_width / 2) == right) sum += p[4 * n + 3];
    return sum;
  };
  bccsplat_clip clip{};
  clip.normal[1] = 1, clip.offset = -1000, clip.instance = second;
  ASSERT_OK(bccsplat_scene_set_clips(scene_.get(), &clip, 1));
  Pixels cut = draw(c, &options);
  EXPECT_NEAR(half_sum(cut, true), half_sum(whole, true), 0.02 * half_sum(whole, true));
  EXPECT_LT(half_sum(cut, false), 0.02 * half_sum(whole, false));
  // In the volume's own space the second one is where the first is.
  clip = {};
  clip.normal[0] = 1, clip.offset = -39.5, clip.space = BCCSPLAT_CLIP_SPACE_VOLUME;
  ASSERT_OK(bccsplat_scene_set_clips(scene_.get(), &clip, 1));
  EXPECT_LT(sum_of(draw(c, &options)), 0.01 * sum_of(whole)) << "both cut away";
  clip.space = BCCSPLAT_CLIP_SPACE_WORLD;
  ASSERT_OK(bccsplat_scene_set_clips(scene_.get(), &clip, 1));
  cut = draw(c, &options);
  EXPECT_LT(half_sum(cut, true), 0.02 * half_sum(whole, true));
  EXPECT_GT(half_sum(cut, false), 0.9 * half_sum(whole, false));
  (void)first;
}

TEST_F(Scenes, ABoxOfTheVolumeIsReadForWhatClipsLeave) {
  (void)add(instance());
  set_time(15);
  const bccsplat_camera c = camera();
  auto options = sized<bccsplat_render_options>();
  options.quality = BCCSPLAT_QUALITY_FINE, options.shading = BCCSPLAT_SHADING_OFF;
  std::vector<bccsplat_clip> faces(6);
  const std::array<double, 16> box{9, 0, 0, 12, 0, 10, 0, 14, 0, 0, 11, 15, 0, 0, 0, 1};
  ASSERT_OK(bccsplat_make_box_clips(box.data(), faces.data()));
  ASSERT_OK(bccsplat_scene_set_clips(scene_.get(), faces.data(), faces.size()));
  const Pixels part = draw(c, &options); // of a slice in a box
  ASSERT_GT(sum_of(part), 5);
  const Scene other = make_scene();
  (void)add(instance(), &other);
  ASSERT_OK(bccsplat_scene_set_time(other.get(), 15));
  (void)draw(c, &options, &other); // the whole slice, which is kept
  ASSERT_OK(bccsplat_scene_set_clips(other.get(), faces.data(), faces.size()));
  EXPECT_LT(largest_difference(draw(c, &options, &other), part), 5e-5);
  EXPECT_EQ(status_.cut, 0u);
}

TEST_F(Scenes, ABudgetEndsInThePicture) {
  (void)add(instance());
  const bccsplat_camera c = camera();
  auto v = sized<bccsplat_view>();
  v.camera = &c;
  Pixels behind(size_t{4} * scene_width * scene_height, 0.25f),
      ends(size_t{scene_width} * scene_height, 1e6f);
  v.background = behind.data(), v.depth = ends.data();
  for (const double t : {15.0, 16.5}) {
    set_time(t);
    const Frame whole = frame(BCCSPLAT_FRAME_VALUE), parts = frame(BCCSPLAT_FRAME_VALUE);
    auto status = sized<bccsplat_scene_status>();
    int calls = 0;
    double before = -1;
    do {
      ASSERT_OK(bccsplat_scene_render(scene_.get(), &v, parts.get(), nullptr, 1e-3, &status));
      ASSERT_GE(status.progress, before);
      before = status.progress;
      ASSERT_LT(++calls, 60);
    } while (!status.complete);
    EXPECT_GT(calls, 1) << "a picture of two bands does not fit into a microsecond";
    EXPECT_EQ(status.progress, 1);
    const Pixels budgeted = pixels(parts);
    ASSERT_OK(bccsplat_scene_render(scene_.get(), &v, whole.get(), nullptr, 0, &status));
    EXPECT_LT(largest_difference(budgeted, pixels(whole)), 1e-4);
  }
  // Something else is another picture, from its beginning.
  auto status = sized<bccsplat_scene_status>();
  const Frame f = frame();
  set_time(12);
  ASSERT_OK(bccsplat_scene_render(scene_.get(), &v, f.get(), nullptr, 1e-3, &status));
  EXPECT_EQ(status.complete, 0u);
  ends.assign(ends.size(), 60);
  do ASSERT_OK(bccsplat_scene_render(scene_.get(), &v, f.get(), nullptr, 1e-3, &status));
  while (!status.complete);
  const Frame whole = frame();
  ASSERT_OK(bccsplat_scene_render(scene_.get(), &v, whole.get(), nullptr, 0, &status));
  EXPECT_LT(largest_difference(pixels(f), pixels(whole)), 1e-4);
  // A generous one is the picture at once.
  ASSERT_OK(bccsplat_scene_render(scene_.get(), &v, f.get(), nullptr, 1e6, &status));
  EXPECT_EQ(status.complete, 1u);
  EXPECT_LT(largest_difference(pixels(f), pixels(whole)), 1e-4);
}

// Edges of surfaces are found by the pixels next to them: those of the next band, or of another part.
TEST_F(Scenes, EdgesAreSmoothWhereBandsAndPartsMeet) {
  Series s; // a surface with folds in all places
  s.nx = s.ny = s.nz = 32, s.nt = 1;
  s.field = [](double x, double y, double z, double) {
    return 50 + 50 * std::sin(x / 2.2) * std::sin(y / 2.4) * std::sin(z / 2.6);
  };
  const Writer writer = make_writer(device_, folder_.file("folds.bcc4"), options_of(s));
  ASSERT_OK(add_frames(writer.get(), s));
  ASSERT_OK(bccsplat_writer_finish(writer.get(), nullptr));
  volume_ = open(device_, folder_.file("folds.bcc4"));
  (void)add(instance());
  auto options = sized<bccsplat_render_options>();
  options.mode = BCCSPLAT_MODE_ISOSURFACE, options.set_mask = BCCSPLAT_RENDER_SET_ISO, options.iso_value = 70;
  options.smooth_edges = BCCSPLAT_SMOOTH_EDGES_ON;
  for (int turn = 7; turn < 12; ++turn) {
    SCOPED_TRACE(turn);
    auto c = sized<bccsplat_camera>();
    ASSERT_OK(bccsplat_slice_fit_camera(cut_time(volume_, 0).get(), BCCSPLAT_PROJECTION_ORTHOGRAPHIC,
                                        20 + 7 * turn, 35 + 31 * turn, scene_width, scene_height, &c));
    c.ortho_height /= 2; // of edges that cross all rows
    auto v = sized<bccsplat_view>();
    v.camera = &c;
    const Pixels whole = draw(c, &options);
    const Scene other = make_scene();
    (void)add(instance(), &other);
    const Frame bands = frame(BCCSPLAT_FRAME_DEPTH);
    auto status = sized<bccsplat_scene_status>();
    for (int calls = 0; calls < 100 && !status.complete; ++calls)
      ASSERT_OK(bccsplat_scene_render(other.get(), &v, bands.get(), &options, 1e-3, &status));
    ASSERT_EQ(status.complete, 1u);
    EXPECT_LT(largest_difference(pixels(bands), whole), 1e-4);
    // The lower rows with two of those above, which are left out.
    constexpr uint32_t beside = 2, begin = 16;
    v.picture_size[0] = scene_width, v.picture_size[1] = scene_height, v.region_begin[1] = begin - beside;
    constexpr uint32_t rows = scene_height - begin + beside;
    bccsplat_frame* f = nullptr;
    ASSERT_OK(bccsplat_frame_create(device_.get(), scene_width, rows, 0, &f));
    const Frame part(f);
    ASSERT_OK(bccsplat_scene_render(other.get(), &v, f, &options, 0, nullptr));
    auto plane = sized<bccsplat_plane>();
    ASSERT_OK(bccsplat_frame_get_channel(f, BCCSPLAT_FRAME_RGBA, &plane));
    const size_t row = size_t{4} * scene_width;
    EXPECT_LT(largest_difference(Pixels(plane.pixels + beside * row, plane.pixels + rows * row),
                                 Pixels(whole.begin() + begin * row, whole.end())),
              1e-4);
  }
}

// A picture within a budget is that of none, whatever else of an instance than its slice takes time.
TEST_F(Scenes, ABudgetEndsWithTheTrail) {
  auto trail = sized<bccsplat_trail>();
  trail.interval[0] = -2.5, trail.samples = 30;
  auto i = instance();
  i.trail = &trail;
  const uint64_t id = add(i);
  const bccsplat_camera c = camera();
  auto v = sized<bccsplat_view>();
  v.camera = &c;
  set_time(16);
  const auto expect_whole = [&] {
    const Frame parts = frame(), whole = frame();
    auto status = sized<bccsplat_scene_status>();
    for (int calls = 0; calls < 100 && !status.complete; ++calls)
      ASSERT_OK(bccsplat_scene_render(scene_.get(), &v, parts.get(), nullptr, 1e-3, &status));
    ASSERT_EQ(status.complete, 1u);
    const Scene other = make_scene();
    (void)add(i, &other);
    ASSERT_OK(bccsplat_scene_set_time(other.get(), 16));
    ASSERT_OK(bccsplat_scene_render(other.get(), &v, whole.get(), nullptr, 0, &status));
    EXPECT_LT(largest_difference(pixels(parts), pixels(whole)), 1e-4);
    i.trail = nullptr;
    const Scene still = make_scene();
    (void)add(i, &still);
    i.trail = &trail;
    ASSERT_OK(bccsplat_scene_set_time(still.get(), 16));
    ASSERT_OK(bccsplat_scene_render(still.get(), &v, whole.get(), nullptr, 0, &status));
    EXPECT_GT(largest_difference(pixels(parts), pixels(whole)), 0.01) << "the trail is seen";
  };
  expect_whole();
  place(i, {1, 0, 0, 3, 0, 1, 0, 0, 0, 0, 1, 0}); // what is there moves, and with it the trail
  ASSERT_OK(bccsplat_scene_set_instance(scene_.get(), id, &i));
  expect_whole();
}

// A picture under way goes on in frames with the same planes alone.
TEST_F(Scenes, ABudgetPictureOfOtherPlanesIsAnotherOne) {
  (void)add(instance());
  set_time(15);
  auto status = sized<bccsplat_scene_status>();
  const auto drawn = [&](uint32_t channels, double budget) {
    Frame f = frame(channels);
    status = sized<bccsplat_scene_status>();
    for (int calls = 0; calls < 100 && !status.complete; ++calls)
      EXPECT_OK(bccsplat_scene_render(scene_.get(), nullptr, f.get(), nullptr, budget, &status));
    EXPECT_EQ(status.complete, 1u);
    return f;
  };
  (void)drawn(0, 1e-3);
  const Frame parts = drawn(BCCSPLAT_FRAME_DEPTH | BCCSPLAT_FRAME_VALUE, 1e-3),
              whole = drawn(BCCSPLAT_FRAME_DEPTH | BCCSPLAT_FRAME_VALUE, 0);
  size_t met = 0;
  for (const uint32_t channel : {BCCSPLAT_FRAME_DEPTH, BCCSPLAT_FRAME_VALUE}) {
    auto a = sized<bccsplat_plane>(), b = sized<bccsplat_plane>();
    ASSERT_OK(bccsplat_frame_get_channel(parts.get(), channel, &a));
    ASSERT_OK(bccsplat_frame_get_channel(whole.get(), channel, &b));
    for (size_t n = 0; n < size_t{scene_width} * scene_height; ++n) {
      ASSERT_EQ(std::isfinite(a.pixels[n]), std::isfinite(b.pixels[n])) << channel << ' ' << n;
      if (!std::isfinite(b.pixels[n])) continue;
      EXPECT_NEAR(a.pixels[n], b.pixels[n], 0.01 * std::fabs(b.pixels[n]) + 1e-3);
      ++met;
    }
  }
  EXPECT_GT(met, 200u);
}

// What a picture took in several calls is what the next one is judged by: where that does not fit a coarse
// picture comes first, of the whole frame.
TEST_F(Scenes, APictureOfManyCallsDoesNotFitIntoOne) {
  (void)add(instance());
  set_time(15);
  auto options = sized<bccsplat_render_options>();
  options.quality = BCCSPLAT_QUALITY_BEST;
  auto v = sized<bccsplat_view>();
  bccsplat_camera c = camera();
  v.camera = &c;
  const Frame f = frame();
  for (int n = 0; n < 5; ++n) {
    c.position[0] += 0.5;
    auto status = sized<bccsplat_scene_status>();
    int calls = 0;
    for (; calls < 100 && !status.complete; ++calls)
      ASSERT_OK(bccsplat_scene_render(scene_.get(), &v, f.get(), &options, 1e-3, &status));
    ASSERT_EQ(status.complete, 1u);
    ASSERT_GT(calls, 4);
    c.position[0] += 0.5;
    ASSERT_OK(bccsplat_scene_render(scene_.get(), &v, f.get(), &options, 1.2 * status.ms_total, &status));
    const Pixels first = pixels(f);
    const Scene other = make_scene();
    (void)add(instance(), &other);
    ASSERT_OK(bccsplat_scene_set_time(other.get(), 15));
    const float whole = sum_of(draw(c, &options, &other));
    EXPECT_NEAR(sum_of(first), whole, 0.15 * whole);
  }
}

// Of several instances the depth of a surface is that of the first hit, as of one.
TEST_F(Scenes, SurfacesOfSeveralHaveTheDepthOfTheFirstHit) {
  const uint64_t first = add(instance());
  auto far = instance();
  place(far, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0});
  set_time(15);
  const bccsplat_camera c = camera(false);
  for (size_t a = 0; a < 3; ++a) // behind the first one
    far.placement[4 * a + 3] = 0.05 * (c.target[a] - c.position[a]);
  auto surface = bccsplat_iso_surface{};
  surface.value = 50, surface.opacity = 0.3;
  auto options = sized<bccsplat_render_options>();
  options.mode = BCCSPLAT_MODE_ISOSURFACE, options.surfaces = &surface, options.surface_count = 1;
  options.smooth_edges = BCCSPLAT_SMOOTH_EDGES_OFF, options.quality = BCCSPLAT_QUALITY_FINE;
  auto v = sized<bccsplat_view>();
  v.camera = &c;
  const auto depths = [&] {
    const Frame f = frame(BCCSPLAT_FRAME_DEPTH);
    EXPECT_OK(bccsplat_scene_render(scene_.get(), &v, f.get(), &options, 0, nullptr));
    auto plane = sized<bccsplat_plane>();
    EXPECT_OK(bccsplat_frame_get_channel(f.get(), BCCSPLAT_FRAME_DEPTH, &plane));
    return std::vector<float>(plane.pixels, plane.pixels + size_t{scene_width} * scene_height);
  };
  const std::vector<float> one = depths();
  (void)add(far);
  const std::vector<float> two = depths();
  size_t met = 0;
  for (size_t n = 0; n < one.size(); ++n) {
    if (!std::isfinite(one[n])) continue;
    EXPECT_NEAR(two[n], one[n], 0.05) << n;
    ++met;
  }
  EXPECT_GT(met, 30u);
  (void)first;
}

// A budget picture holds a copy of the frame, its slices and what they are drawn from: all of it counts.
// Where that is too much for the device the call says so, or stays with what fits, and the device never holds
// more.
TEST_F(Scenes, ABudgetPictureStaysWithinTheMemoryBudget) {
  constexpr uint32_t edge = 512;
  constexpr uint64_t picture_bytes = uint64_t{edge} * edge * 16;
  const auto bytes_of = [](bccsplat_device* device) {
    auto info = sized<bccsplat_device_info>();
    EXPECT_OK(bccsplat_device_get_info(device, &info));
    return info;
  };
  int complete = 0, refused = 0;
  for (const uint64_t budget :
       {uint64_t{0}, 48 * picture_bytes / 10, 3 * picture_bytes, 2 * picture_bytes + 1000}) {
    SCOPED_TRACE(budget);
    const Device device = make_device(2, budget);
    const Volume volume = open(device, folder_.file("s.bcc4"));
    bccsplat_scene* scene = nullptr;
    ASSERT_OK(bccsplat_scene_create(device.get(), &scene));
    const Scene owner(scene);
    const auto i = instance();
    uint64_t id = 0;
    ASSERT_OK(bccsplat_scene_add(scene, volume.get(), &i, &id));
    ASSERT_OK(bccsplat_scene_set_time(scene, 15));
    bccsplat_frame* f = nullptr;
    ASSERT_OK(bccsplat_frame_create(device.get(), edge, edge, 0, &f));
    const Frame frame(f);
    auto status = sized<bccsplat_scene_status>();
    bccsplat_status answer = BCCSPLAT_OK;
    for (int n = 0; n < 400 && answer == BCCSPLAT_OK && !status.complete; ++n)
      answer = bccsplat_scene_render(scene, nullptr, f, nullptr, 5, &status);
    const auto info = bytes_of(device.get());
    EXPECT_LE(info.memory_peak, info.memory_budget);
    if (answer == BCCSPLAT_OK) {
      EXPECT_EQ(status.complete, 1u);
      EXPECT_GE(info.memory_peak, 2 * picture_bytes) << "the frame and the picture so far";
      ++complete;
    } else {
      EXPECT_EQ(answer, BCCSPLAT_ERROR_MEMORY_BUDGET) << bccsplat_last_error();
      ++refused;
    }
    // What is refused leaves the scene as it was, and it is drawn where there is room.
    std::vector<float> outside(size_t{64} * 64 * 4);
    bccsplat_frame* small = nullptr;
    ASSERT_OK(bccsplat_frame_wrap(device.get(), 64, 64, outside.data(), 0, &small));
    const Frame smaller(small);
    const bccsplat_status again = bccsplat_scene_render(scene, nullptr, small, nullptr, 0, &status);
    EXPECT_TRUE(again == BCCSPLAT_OK || (answer != BCCSPLAT_OK && again == BCCSPLAT_ERROR_MEMORY_BUDGET));
  }
  EXPECT_GE(complete, 1);
  EXPECT_GE(refused, 1);
}

TEST_F(Scenes, PrefetchLeavesNothingToRead) {
  (void)add(instance());
  const bccsplat_camera c = camera();
  auto v = sized<bccsplat_view>();
  v.camera = &c;
  ASSERT_OK(bccsplat_scene_prefetch(scene_.get(), &v, scene_width, scene_height, nullptr, 15));
  set_time(15);
  (void)draw(c);
  EXPECT_EQ(status_.cut, 1u);
  EXPECT_EQ(status_.bytes_read, 0u);
  EXPECT_OK(bccsplat_scene_prefetch(scene_.get(), &v, scene_width, scene_height, nullptr, 99))
      << "nothing is there";
}

TEST_F(Scenes, RangesAreWhatIsReadForAnInstance) {
  FarFile far(file_bytes(folder_.file("s.bcc4")));
  const auto stream = far.stream(1);
  bccsplat_volume* opened = nullptr;
  ASSERT_OK(bccsplat_volume_open_stream(device_.get(), &stream, nullptr, &opened));
  const Volume volume(opened);
  const auto i = instance();
  uint64_t id = 0, count = 0;
  ASSERT_OK(bccsplat_scene_add(scene_.get(), opened, &i, &id));
  const bccsplat_camera c = camera();
  auto v = sized<bccsplat_view>();
  v.camera = &c;
  const auto ask = [&](uint32_t flags) {
    std::vector<uint64_t> pairs(2000);
    EXPECT_OK(bccsplat_scene_get_ranges(scene_.get(), &v, scene_width, scene_height, nullptr, 15, id, flags,
                                        pairs.data(), pairs.size() / 2, &count));
    std::vector<Range> out;
    for (uint64_t n = 0; n < count; ++n) out.emplace_back(pairs[2 * n], pairs[2 * n + 1]);
    return out;
  };
  const auto ranges = ask(0);
  far.forget();
  set_time(15);
  (void)draw(c);
  EXPECT_FALSE(far.reads.empty());
  EXPECT_TRUE(covers(ranges, far.reads));
  EXPECT_LT(bytes_of(ranges), far.bytes.size()) << "of all moments";
  EXPECT_GT(bytes_of(far.reads), bytes_of(ranges) / 2);
  EXPECT_TRUE(ask(BCCSPLAT_RANGES_MISSING).empty()) << "it was drawn";
  EXPECT_OK(bccsplat_scene_get_ranges(scene_.get(), &v, scene_width, scene_height, nullptr, 99, id, 0,
                                      nullptr, 0, &count));
  EXPECT_EQ(count, 0u) << "nothing is there";
}

TEST_F(Scenes, AnotherThreadReadsAheadWhileThisOneDraws) {
  const uint64_t id = add(instance());
  const bccsplat_camera c = camera();
  auto v = sized<bccsplat_view>();
  v.camera = &c;
  std::atomic<bool> done{false};
  std::thread ahead([&] {
    for (int n = 0; !done; ++n)
      EXPECT_OK(
          bccsplat_scene_prefetch(scene_.get(), &v, scene_width, scene_height, nullptr, 10 + n % 28 * 0.5));
  });
  for (int n = 0; n < 20; ++n) {
    set_time(10 + n % 10);
    auto i = instance();
    i.placement[15] = 0, i.density = 1 + n % 2;
    ASSERT_OK(bccsplat_scene_set_instance(scene_.get(), id, &i));
    const uint64_t other = add(i);
    (void)draw(c);
    ASSERT_OK(bccsplat_scene_remove(scene_.get(), other));
  }
  done = true;
  ahead.join();
}

TEST_F(Scenes, NonsenseIsRefused) {
  auto i = instance();
  uint64_t id = 0;
  const auto refused = [&](int32_t status) {
    return bccsplat_scene_add(scene_.get(), volume_.get(), &i, &id) == status;
  };
  i.channel = 3;
  EXPECT_TRUE(refused(BCCSPLAT_ERROR_NOT_FOUND));
  i = instance();
  place(i, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0});
  EXPECT_TRUE(refused(BCCSPLAT_ERROR_INVALID_ARGUMENT)) << "flat";
  place(i, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0});
  i.placement[12] = 3; // column-major
  EXPECT_TRUE(refused(BCCSPLAT_ERROR_INVALID_ARGUMENT));
  EXPECT_NE(std::string(bccsplat_last_error()).find("row-major"), std::string::npos);
  i = instance(), i.density = -1;
  EXPECT_TRUE(refused(BCCSPLAT_ERROR_INVALID_ARGUMENT));
  i = instance(), i.outside = 4;
  EXPECT_TRUE(refused(BCCSPLAT_ERROR_INVALID_ARGUMENT));
  EXPECT_EQ(bccsplat_scene_set_time(scene_.get(), NAN), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  const Device other = make_device();
  const Volume elsewhere = open(other, folder_.file("s.bcc4"));
  EXPECT_EQ(bccsplat_scene_add(scene_.get(), elsewhere.get(), nullptr, &id), BCCSPLAT_ERROR_INVALID_HANDLE);
  ASSERT_OK(bccsplat_scene_add(scene_.get(), volume_.get(), nullptr, &id));
  ASSERT_OK(bccsplat_scene_add(scene_.get(), volume_.get(), nullptr, &id));
  set_time(15);
  const Frame deep = frame(BCCSPLAT_FRAME_DEEP), value = frame(BCCSPLAT_FRAME_VALUE);
  EXPECT_EQ(bccsplat_scene_render(scene_.get(), nullptr, value.get(), nullptr, 0, nullptr),
            BCCSPLAT_ERROR_UNSUPPORTED)
      << "of two volumes";
  auto surfaces = sized<bccsplat_render_options>();
  surfaces.mode = BCCSPLAT_MODE_ISOSURFACE, surfaces.iso_value = 50;
  surfaces.set_mask = BCCSPLAT_RENDER_SET_ISO;
  EXPECT_EQ(bccsplat_scene_render(scene_.get(), nullptr, deep.get(), &surfaces, 0, nullptr),
            BCCSPLAT_ERROR_UNSUPPORTED);
  EXPECT_EQ(bccsplat_scene_render(scene_.get(), nullptr, deep.get(), nullptr, 10, nullptr),
            BCCSPLAT_ERROR_UNSUPPORTED);
  const Frame f = frame();
  EXPECT_EQ(bccsplat_scene_render(scene_.get(), nullptr, f.get(), nullptr, -1, nullptr),
            BCCSPLAT_ERROR_INVALID_ARGUMENT);
  EXPECT_OK(bccsplat_scene_render(scene_.get(), nullptr, f.get(), nullptr, 0, nullptr));
}

} // namespace
