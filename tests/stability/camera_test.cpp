// SPDX-License-Identifier: Apache-2.0
// Cameras and worlds far from comfortable.
#include "tests/stability/stability.h"

namespace host {
namespace {

const Series scene{.nx = 24, .ny = 22, .nz = 20, .nt = 3, .field = [](double x, double y, double z, double) {
                     return 100 *
                            std::exp(-(std::pow(x - 11, 2) + std::pow(y - 10, 2) + std::pow(z - 9, 2)) / 30);
                   }};
const Ramp ramp{5, 100, 0.2, 1};

[[nodiscard]] bccsplat_camera fitted(const Slice& slice, int32_t projection) {
  auto camera = sized<bccsplat_camera>();
  EXPECT_OK(bccsplat_slice_fit_camera(slice.get(), projection, 20, 30, 48, 48, &camera));
  return camera;
}

TEST(StabilityCamera, AMillionUnitsFromTheOriginIsTheSamePicture) {
  const Device device = make_device();
  std::vector<float> near;
  for (const double offset : {0.0, 1e6}) {
    bccsplat_writer_options o = options_of(scene);
    for (int i = 0; i < 4; ++i) o.affine[5 * i] = 1;
    for (int i = 0; i < 3; ++i) o.affine[4 * i + 3] = offset;
    const Stored stored = store(device, scene, o);
    const Slice slice = cut_time(stored.volume, 1);
    const bccsplat_camera camera = fitted(slice, BCCSPLAT_PROJECTION_PERSPECTIVE);
    const std::vector<float> got = picture(device, slice, {.ramp = ramp, .camera = &camera});
    if (offset == 0)
      near = got;
    else
      Bound("picture, 1e6 units away", 1e-4).add(largest_difference(near, got));
  }
  EXPECT_GT(*std::max_element(near.begin(), near.end()), 0.3f);
}

TEST(StabilityCamera, MovingByWholePixelsMovesThePicture) {
  // A transform that lost 1/256 pixel over the picture could not repeat itself pixel by pixel.
  const Device device = make_device();
  const Stored stored = store(device, scene);
  const Slice slice = cut_time(stored.volume, 1);
  bccsplat_camera camera = fitted(slice, BCCSPLAT_PROJECTION_ORTHOGRAPHIC);
  camera.position[0] = camera.target[0] = 11, camera.position[1] = camera.target[1] = 10;
  camera.position[2] = -100, camera.target[2] = 9;
  camera.up[0] = 0, camera.up[1] = 1, camera.up[2] = 0;
  const double pixel = camera.ortho_height / 48;
  const std::vector<float> first = picture(device, slice, {.ramp = ramp, .camera = &camera});
  camera.position[1] += 7 * pixel, camera.target[1] += 7 * pixel;
  const std::vector<float> second = picture(device, slice, {.ramp = ramp, .camera = &camera});
  Bound bound("picture moved by 7 pixels", 2e-5);
  for (size_t row = 0; row + 7 < 48; ++row)
    for (size_t i = 0; i < 48 * 4; ++i)
      bound.add(static_cast<double>(first[row * 48 * 4 + i]) - second[(row + 7) * 48 * 4 + i]);
}

TEST(StabilityCamera, InsideAtASiteGrazingAndBehind) {
  const Device device = make_device();
  const Stored stored = store(device, scene);
  const Slice slice = cut_time(stored.volume, 1);
  struct Case {
    double position[3], target[3];
    bool sees;
  };
  for (const Case& c : {Case{{11, 10, 5}, {11, 10, 15}, true}, // inside
                        Case{{11, 10, 9}, {12, 11, 10}, true}, // exactly at a site, in the middle of the blob
                        Case{{-5, 0, 9}, {40, 0, 9}, true},    // in the plane of a face
                        Case{{-20, 10, 9}, {-40, 10, 9}, false}, // looking away
                        Case{{11, 10, 9.0000001}, {11, 10, -50}, true}}) {
    auto camera = sized<bccsplat_camera>();
    camera.projection = BCCSPLAT_PROJECTION_PERSPECTIVE;
    std::copy_n(c.position, 3, camera.position);
    std::copy_n(c.target, 3, camera.target);
    camera.up[1] = 1;
    camera.fovy_degrees = 50;
    const std::vector<float> got = picture(device, slice, {.ramp = ramp, .camera = &camera});
    ASSERT_TRUE(all_finite(got));
    const float most = *std::max_element(got.begin(), got.end());
    EXPECT_LE(most, 1.0001f);
    if (c.sees)
      EXPECT_GT(most, 0.1f) << c.position[2];
    else
      EXPECT_LT(most, 0.2f) << c.position[0];
  }
}

TEST(StabilityCamera, AnglesNearZeroAndNearAHalfTurn) {
  const Device device = make_device();
  const Stored stored = store(device, scene);
  const Slice slice = cut_time(stored.volume, 1);
  // Very narrow and very far is orthographic.
  bccsplat_camera flat = fitted(slice, BCCSPLAT_PROJECTION_ORTHOGRAPHIC);
  bccsplat_camera narrow = flat;
  narrow.projection = BCCSPLAT_PROJECTION_PERSPECTIVE;
  narrow.fovy_degrees = 0.01;
  double view[3], length = 0;
  for (int i = 0; i < 3; ++i) view[i] = flat.target[i] - flat.position[i], length += view[i] * view[i];
  length = std::sqrt(length);
  const double distance = flat.ortho_height / 2 / std::tan(0.005 * std::numbers::pi / 180);
  for (int i = 0; i < 3; ++i) narrow.position[i] = flat.target[i] - view[i] / length * distance;
  auto options = sized<bccsplat_render_options>();
  options.shading = BCCSPLAT_SHADING_OFF;
  const Shot a{.ramp = ramp, .camera = &flat, .options = options},
      b{.ramp = ramp, .camera = &narrow, .options = options};
  Bound("fovy 0.01 degrees against orthographic", 5e-3)
      .add(largest_difference(picture(device, slice, a), picture(device, slice, b)));
  // Very wide is finite.
  bccsplat_camera wide = fitted(slice, BCCSPLAT_PROJECTION_PERSPECTIVE);
  for (const double degrees : {120.0, 150.0, 170.0}) {
    wide.fovy_degrees = degrees;
    EXPECT_TRUE(all_finite(picture(device, slice, {.ramp = ramp, .camera = &wide}))) << degrees;
  }
}

TEST(StabilityCamera, ZoomFromAThousandthToAThousand) {
  const Device device = make_device();
  const Stored stored = store(device, scene);
  const Slice slice = cut_time(stored.volume, 1);
  const bccsplat_camera fit = fitted(slice, BCCSPLAT_PROJECTION_ORTHOGRAPHIC);
  for (const double zoom : {1e-3, 1e-2, 0.1, 10.0, 100.0, 1e3}) {
    bccsplat_camera camera = fit;
    camera.ortho_height = fit.ortho_height / zoom;
    const std::vector<float> got = picture(device, slice, {.ramp = ramp, .camera = &camera});
    ASSERT_TRUE(all_finite(got)) << zoom;
    if (zoom >= 10) { // the blob's middle fills the view: neighbours hardly differ
      const size_t centre = (24 * 48 + 24) * 4;
      EXPECT_GT(got[centre + 3], 0.3f) << zoom;
      Bound("neighbours in the middle at zoom " + shown(zoom), 0.05)
          .add(static_cast<double>(got[centre + 3]) - got[centre + 7]);
    }
  }
}

// No sheet lies between the eye and the face that it looks out of. The picture is drawn again of sheets that
// were kept, of which there are none.
TEST(StabilityCamera, NearerToAFaceThanASheetThereIsNothing) {
  const Device device = make_device();
  const Stored stored = store(device, Series{.nx = 16, .ny = 16, .nz = 16, .nt = 1});
  const Slice slice = cut_time(stored.volume, 0);
  auto camera = sized<bccsplat_camera>();
  camera.projection = BCCSPLAT_PROJECTION_PERSPECTIVE, camera.fovy_degrees = 30;
  camera.position[0] = camera.position[1] = camera.target[0] = camera.target[1] = 8;
  camera.position[2] = 14.3, camera.target[2] = 20, camera.up[1] = 1;
  auto options = sized<bccsplat_render_options>();
  options.mode = BCCSPLAT_MODE_ISOSURFACE, options.set_mask = BCCSPLAT_RENDER_SET_ISO, options.iso_value = 50;
  options.sheet_step = 3.6;
  bccsplat_renderer* r = nullptr;
  ASSERT_OK(bccsplat_renderer_create(device.get(), &r));
  const Renderer renderer(r);
  ASSERT_OK(bccsplat_renderer_set_slice(r, slice.get()));
  ASSERT_OK(bccsplat_renderer_set_camera(r, &camera));
  ASSERT_OK(bccsplat_renderer_set_options(r, &options));
  bccsplat_frame* f = nullptr;
  ASSERT_OK(bccsplat_frame_create(device.get(), 16, 16, BCCSPLAT_FRAME_RGBA | BCCSPLAT_FRAME_DEEP, &f));
  const Frame frame(f);
  for (int n = 0; n < 3; ++n) {
    ASSERT_OK(bccsplat_renderer_render(r, f));
    auto plane = sized<bccsplat_plane>();
    ASSERT_OK(bccsplat_frame_get_channel(f, BCCSPLAT_FRAME_RGBA, &plane));
    EXPECT_EQ(static_cast<const float*>(plane.pixels)[3], 0) << n;
  }
}

} // namespace
} // namespace host
