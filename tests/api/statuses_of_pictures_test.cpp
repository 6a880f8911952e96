// SPDX-License-Identifier: Apache-2.0
// What slices, renderers and frames may answer.
#include "statuses.h"

namespace host::statuses {
namespace {

const auto nothing = [](auto&) {};

TEST(Statuses, OfSlices) {
  static float value = 0;
  static const double far[3] = {500, 0, 0};
  expect_rows({
      {"channel", BCCSPLAT_ERROR_NOT_FOUND,
       [](Scene& s) { return s.cut_with(now, [](auto& o) { o.channel = 1; }); }},
      {"kernel", BCCSPLAT_ERROR_NOT_FOUND,
       [](Scene& s) { return s.cut_with(now, [](auto& o) { o.kernel = "none such"; }); }},
      {"level", BCCSPLAT_ERROR_NOT_FOUND,
       [](Scene& s) { return s.cut_with(now, [](auto& o) { o.level = 1; }); }},
      {"time", BCCSPLAT_ERROR_OUT_OF_DOMAIN,
       [](Scene& s) { return s.cut_with(plane_of(0, 0, 0, 1, -9), nothing); }},
      {"a box beside the samples", BCCSPLAT_ERROR_OUT_OF_DOMAIN,
       [](Scene& s) {
         static const double box[6] = {50, 0, 0, 60, 5, 5};
         return s.cut_with(now, [](bccsplat_slice_options& o) { o.box = box; });
       }},
      {"a box that ends before it begins", BCCSPLAT_ERROR_INVALID_ARGUMENT,
       [](Scene& s) {
         static const double box[6] = {5, 9, 5, 9, 5, 9};
         return s.cut_with(now, [](bccsplat_slice_options& o) { o.box = box; });
       }},
      {"an oblique one merged", BCCSPLAT_ERROR_UNSUPPORTED,
       [](Scene& s) { return s.cut_with(tilted, [](auto& o) { o.method = BCCSPLAT_METHOD_MERGED; }); }},
      {"an interval off the time axis", BCCSPLAT_ERROR_UNSUPPORTED,
       [](Scene& s) { return s.cut_with(tilted, [](auto& o) { o.interval[1] = 2; }); }},
      {"too many planes", BCCSPLAT_ERROR_LIMIT_EXCEEDED,
       [](Scene& s) { return s.cut_with(tilted, [](auto& o) { o.spacing = 1e-6; }); }},
      {"prefetch of an oblique one", BCCSPLAT_ERROR_UNSUPPORTED,
       [](Scene& s) { return bccsplat_volume_prefetch(s.volume.get(), &tilted, nullptr); }},
      {"ranges of no channel", BCCSPLAT_ERROR_NOT_FOUND,
       [](Scene& s) {
         auto o = sized<bccsplat_slice_options>();
         o.channel = 1;
         uint64_t count = 0;
         return bccsplat_volume_get_ranges(s.volume.get(), &now, &o, 0, nullptr, 0, &count);
       }},
      {"a point outside", BCCSPLAT_ERROR_OUT_OF_DOMAIN,
       [](Scene& s) { return bccsplat_slice_evaluate(s.slice.get(), 1, far, &value, nullptr); }},
      {"a trail of extracted points", BCCSPLAT_ERROR_UNSUPPORTED,
       [](Scene& s) {
         auto o = sized<bccsplat_slice_options>();
         o.method = BCCSPLAT_METHOD_EXTRACTED;
         bccsplat_slice* made = nullptr;
         EXPECT_OK(bccsplat_slice_create(s.volume.get(), &now, &o, &made));
         const Slice slice(made);
         const double at[3] = {4, 4, 4};
         float gradient[3];
         EXPECT_OK(s.render_with(nothing, &slice));
         EXPECT_OK(bccsplat_slice_evaluate(made, 1, at, &value, gradient));
         auto trail = sized<bccsplat_trail>();
         trail.interval[0] = -1;
         EXPECT_OK(bccsplat_renderer_set_trail(s.renderer.get(), &trail));
         return s.render_with(nothing, &slice);
       }},
      {"what a picture needs of an oblique slice", BCCSPLAT_ERROR_UNSUPPORTED,
       [](Scene& s) {
         auto camera = sized<bccsplat_camera>();
         EXPECT_OK(bccsplat_slice_fit_camera(s.oblique.get(), 0, 20, 30, 16, 16, &camera));
         auto needs = sized<bccsplat_picture_needs>();
         return bccsplat_slice_get_picture_needs(s.oblique.get(), &camera, 16, 16, nullptr, &needs);
       }},
  });
}

// A box without extent along an axis can be sampled, and is drawn one sample thick.
TEST(Statuses, OfFlatBoxes) {
  const Scene scene;
  const double box[6] = {6, 10, 9, 12, 10, 14};
  auto o = sized<bccsplat_slice_options>();
  o.box = box;
  bccsplat_slice* made = nullptr;
  ASSERT_OK(bccsplat_slice_create(scene.volume.get(), &now, &o, &made));
  const Slice flat(made);
  auto info = sized<bccsplat_slice_info>();
  ASSERT_OK(bccsplat_slice_get_info(made, &info));
  EXPECT_EQ(info.dims[1], 1u);
  std::vector<float> values(info.dims[0] * info.dims[1] * info.dims[2]);
  ASSERT_OK(bccsplat_slice_sample_grid(made, nullptr, values.data()));
  ASSERT_EQ(values.size(), 7u * 6);
  for (const float v : values) EXPECT_FALSE(std::isnan(v));
  const double at[3] = {8.5, 10, 10.5};
  float of_box = 0, whole = 1;
  ASSERT_OK(bccsplat_slice_evaluate(made, 1, at, &of_box, nullptr));
  ASSERT_OK(bccsplat_slice_evaluate(scene.slice.get(), 1, at, &whole, nullptr));
  EXPECT_EQ(of_box, whole);
  const auto drawn = [&](const Slice& of) {
    EXPECT_OK(scene.render_with(nothing, &of));
    const float* const pixels = scene.pixels();
    double sum = 0;
    for (size_t i = 0; i < 16 * 16; ++i) sum += pixels[4 * i + 3];
    return sum;
  };
  const double as_thick[6] = {6, 9.5, 9, 12, 10.5, 14};
  o.box = as_thick;
  ASSERT_OK(bccsplat_slice_create(scene.volume.get(), &now, &o, &made));
  const double expected = drawn(Slice(made));
  EXPECT_GT(expected, 20);
  EXPECT_NEAR(drawn(flat) / expected, 1, 0.05);
}

TEST(Statuses, OfPictures) {
  expect_rows({
      {"no slice", BCCSPLAT_ERROR_WRONG_STATE,
       [](Scene& s) { return bccsplat_renderer_render(s.renderer.get(), s.frame.get()); }},
      {"no picture yet", BCCSPLAT_ERROR_WRONG_STATE,
       [](Scene& s) {
         auto stats = sized<bccsplat_render_stats>();
         return bccsplat_renderer_get_stats(s.renderer.get(), &stats);
       }},
      {"a trail of an X-ray", BCCSPLAT_ERROR_UNSUPPORTED,
       [](Scene& s) {
         auto trail = sized<bccsplat_trail>();
         trail.interval[0] = -2;
         EXPECT_OK(bccsplat_renderer_set_trail(s.renderer.get(), &trail));
         return s.render_with([](auto& o) { o.mode = BCCSPLAT_MODE_XRAY; });
       }},
      {"a deep reference", BCCSPLAT_ERROR_UNSUPPORTED,
       [](Scene& s) {
         s.frame = s.make_frame(BCCSPLAT_FRAME_RGBA | BCCSPLAT_FRAME_DEEP);
         return s.render_with([](auto& o) { o.reference = 1; });
       }},
      {"another device's slice", BCCSPLAT_ERROR_INVALID_HANDLE,
       [](Scene& s) {
         const Device other = make_device();
         const Slice slice = cut_time(open(other, s.path), 1);
         return bccsplat_renderer_set_slice(s.renderer.get(), slice.get());
       }},
      {"fields of view", BCCSPLAT_ERROR_INVALID_ARGUMENT,
       [](Scene& s) {
         auto camera = sized<bccsplat_camera>();
         EXPECT_OK(bccsplat_slice_fit_camera(s.slice.get(), BCCSPLAT_PROJECTION_PERSPECTIVE, 20, 30, 16, 16,
                                             &camera));
         for (const double angle : {0.001, 170.0}) {
           camera.fovy_degrees = angle;
           EXPECT_OK(bccsplat_renderer_set_camera(s.renderer.get(), &camera));
         }
         camera.fovy_degrees = 171;
         EXPECT_EQ(bccsplat_renderer_set_camera(s.renderer.get(), &camera), BCCSPLAT_ERROR_INVALID_ARGUMENT);
         camera.fovy_degrees = 0.0009;
         return bccsplat_renderer_set_camera(s.renderer.get(), &camera);
       }},
      {"no such plane", BCCSPLAT_ERROR_NOT_FOUND,
       [](Scene& s) {
         auto plane = sized<bccsplat_plane>();
         return bccsplat_frame_get_channel(s.frame.get(), BCCSPLAT_FRAME_DEPTH, &plane);
       }},
      {"no deep samples", BCCSPLAT_ERROR_NOT_FOUND,
       [](Scene& s) {
         auto deep = sized<bccsplat_deep>();
         return bccsplat_frame_get_deep(s.frame.get(), &deep);
       }},
      {"no deep samples yet", BCCSPLAT_ERROR_WRONG_STATE,
       [](Scene& s) {
         s.frame = s.make_frame(BCCSPLAT_FRAME_RGBA | BCCSPLAT_FRAME_DEEP);
         auto deep = sized<bccsplat_deep>();
         return bccsplat_frame_get_deep(s.frame.get(), &deep);
       }},
  });
}

// From within a volume the narrowest view that is taken shows what a wider one has in its midst, shaded, too.
TEST(Statuses, OfTheNarrowestViews) {
  const Scene scene;
  auto camera = sized<bccsplat_camera>();
  camera.projection = BCCSPLAT_PROJECTION_PERSPECTIVE, camera.up[1] = 1;
  const double inside[3] = {8, 9, 5}, ahead[3] = {9, 10, 9};
  std::copy_n(inside, 3, camera.position), std::copy_n(ahead, 3, camera.target);
  const auto middle = [&](double angle) {
    camera.fovy_degrees = angle;
    EXPECT_OK(bccsplat_renderer_set_camera(scene.renderer.get(), &camera));
    EXPECT_OK(scene.render_with(nothing));
    const float* pixel = scene.pixels() + (8 * 16 + 8) * 4;
    return std::vector<double>(pixel, pixel + 4);
  };
  const std::vector<double> wide = middle(1);
  EXPECT_GT(wide[3], 0.1);
  for (const double angle : {0.1, 0.01, 0.001}) {
    const std::vector<double> narrow = middle(angle);
    for (size_t c = 0; c < 4; ++c) EXPECT_NEAR(narrow[c], wide[c], 0.05) << angle << ", " << c;
  }
}

TEST(Statuses, OfSaving) {
  {
    const Scene scene;
    const bccsplat_status status =
        bccsplat_frame_save_png(scene.frame.get(), scene.folder.file("a.png").c_str(), nullptr);
    if (status == BCCSPLAT_ERROR_MISSING_FEATURE) GTEST_SKIP() << "built without images";
    ASSERT_OK(status);
  }
  expect_rows({
      {"no folder", BCCSPLAT_ERROR_FILE_NOT_FOUND,
       [](Scene& s) {
         const std::string path = s.folder.file("no/a.png");
         EXPECT_EQ(bccsplat_frame_save_exr(s.frame.get(), path.c_str(), nullptr),
                   BCCSPLAT_ERROR_FILE_NOT_FOUND);
         return bccsplat_frame_save_png(s.frame.get(), path.c_str(), nullptr);
       }},
      {"a file that exists", BCCSPLAT_ERROR_FILE_EXISTS,
       [](Scene& s) {
         EXPECT_EQ(bccsplat_frame_save_exr(s.frame.get(), s.path.c_str(), nullptr),
                   BCCSPLAT_ERROR_FILE_EXISTS);
         return bccsplat_frame_save_png(s.frame.get(), s.path.c_str(), nullptr);
       }},
      {"flat pixels as deep ones", BCCSPLAT_ERROR_NOT_FOUND,
       [](Scene& s) {
         return bccsplat_frame_save_deep_exr(s.frame.get(), s.folder.file("a.exr").c_str(), nullptr);
       }},
      {"deep pixels before a render", BCCSPLAT_ERROR_WRONG_STATE,
       [](Scene& s) {
         s.frame = s.make_frame(BCCSPLAT_FRAME_RGBA | BCCSPLAT_FRAME_DEEP);
         return bccsplat_frame_save_deep_exr(s.frame.get(), s.folder.file("a.exr").c_str(), nullptr);
       }},
      {"a stream that fails", BCCSPLAT_ERROR_IO,
       [](Scene& s) {
         Sink sink;
         sink.fail_at = 0;
         const auto stream = sink.stream();
         return bccsplat_frame_save_stream(s.frame.get(), BCCSPLAT_IMAGE_PNG, &stream, nullptr);
       }},
  });
}

} // namespace
} // namespace host::statuses
