// SPDX-License-Identifier: Apache-2.0
// Single precision where much is added up, or far from the origin.
#include "tests/stability/stability.h"

namespace host {
namespace {

using Point = std::array<double, 3>;

[[nodiscard]] Point cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
[[nodiscard]] double dot(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
[[nodiscard]] Point unit(const Point& a) {
  const double length = std::sqrt(dot(a, a));
  return {a[0] / length, a[1] / length, a[2] / length};
}

// An orthographic view, for closed forms.
struct View {
  Point forward, right, up, target;
  double pixel; // world units

  View(const Point& direction, const Point& at, double unit_per_pixel)
      : forward(unit(direction)), right(unit(cross(forward, {0, 1, 0}))), up(cross(right, forward)),
        target(at), pixel(unit_per_pixel) {}
  [[nodiscard]] bccsplat_camera camera(uint32_t size, double distance) const {
    auto c = sized<bccsplat_camera>();
    c.projection = BCCSPLAT_PROJECTION_ORTHOGRAPHIC;
    for (size_t i = 0; i < 3; ++i)
      c.position[i] = target[i] - distance * forward[i], c.target[i] = target[i], c.up[i] = up[i];
    c.ortho_height = size * pixel;
    return c;
  }
};

// The middle of an X-ray picture in pixels, x to the right and y down.
[[nodiscard]] std::array<double, 2> middle(const std::vector<float>& rgba, uint32_t size) {
  double sum = 0, x = 0, y = 0;
  for (uint32_t row = 0; row < size; ++row)
    for (uint32_t column = 0; column < size; ++column) {
      const double v = rgba[(size_t{row} * size + column) * 4];
      sum += v, x += v * (column + 0.5), y += v * (row + 0.5);
    }
  return {x / sum, y / sum};
}

TEST(StabilityPrecision, ABlobAtTheFarCornerOf4096CubedStandsWhereItShould) {
  const Device device = make_device();
  constexpr int64_t edge = 4096, box_edge = 56;
  bccsplat_writer_options o = options_of({.nx = edge, .ny = edge, .nz = edge, .nt = 1});
  Stored stored;
  const Writer writer = make_writer(device, *stored.file, o);
  bccsplat_writer* const w = writer.get();
  const Point centre{4063.3, 4058.7, 4061.9};
  std::vector<float> values;
  for (int64_t z = 0; z < box_edge; ++z)
    for (int64_t y = 0; y < box_edge; ++y)
      for (int64_t x = 0; x < box_edge; ++x) {
        double square = 0;
        const std::array<int64_t, 3> at{x, y, z};
        for (size_t a = 0; a < 3; ++a)
          square += std::pow(static_cast<double>(edge - box_edge + at[a]) - centre[a], 2);
        values.push_back(static_cast<float>(std::exp(-square / 24)));
      }
  auto box = sized<bccsplat_box>();
  box.type = BCCSPLAT_TYPE_F32, box.data = values.data();
  for (int a = 0; a < 3; ++a) box.begin[a] = edge - box_edge, box.dims[a] = box_edge;
  ASSERT_OK(bccsplat_writer_add_frame(w, 0, 0, &box, 1));
  ASSERT_OK(bccsplat_writer_finish(w, nullptr));
  auto reading = sized<bccsplat_volume_options>();
  reading.kernel = "paper"; // whose prefilter has nothing to do on the empty rest
  bccsplat_volume* v = nullptr;
  ASSERT_OK(bccsplat_volume_open_memory(device.get(), stored.file->bytes.data(), stored.file->bytes.size(),
                                        &reading, &v));
  stored.volume.reset(v);
  const Slice slice = cut_time(stored.volume, 0);
  Bound bound("centre of a blob, pixels", 1.0 / 256);
  constexpr uint32_t size = 160;
  for (const Point& direction : {Point{0, 0, 1}, Point{-1, 0, 0}, Point{1, -2, 0.7}, Point{0.3, 0.4, -0.9}})
    for (const double pixels : {1.0, 2.0, 3.0}) { // per sample
      View view(direction, centre, 1 / pixels);
      const double right = 7.3 * view.pixel, up = -4.1 * view.pixel; // the blob is that far off the middle
      for (size_t i = 0; i < 3; ++i) view.target[i] -= right * view.right[i] + up * view.up[i];
      const bccsplat_camera camera = view.camera(size, 5000);
      Shot shot{.width = size, .height = size, .ramp = {}, .camera = &camera};
      shot.options.mode = BCCSPLAT_MODE_XRAY;
      const auto at = middle(picture(device, slice, shot), size);
      bound.add(at[0] - (0.5 * size + 7.3));
      bound.add(at[1] - (0.5 * size + 4.1));
    }
}

TEST(StabilityPrecision, TenMillionSplatsAddUpToTheLengthOfTheWay) {
  // X-rays through a cube of ones: every one of 10^7 points is splatted, in floats, and each pixel has the
  // length of its ray inside.
  const Device device = make_device();
  constexpr uint32_t n = 244, size = 256;
  const Stored stored = store(
      device,
      Series{.nx = n, .ny = n, .nz = n, .nt = 1, .field = [](double, double, double, double) { return 1; }});
  const Slice slice = cut_time(stored.volume, 0);
  auto info = sized<bccsplat_slice_info>();
  ASSERT_OK(bccsplat_slice_get_info(slice.get(), &info));
  ASSERT_GE(info.points, 10'000'000u);
  const double half = 0.5 * (n - 1);
  const View view({0.5, -0.35, 0.8}, {half, half, half}, 1.7);
  const bccsplat_camera camera = view.camera(size, 1000);
  Shot shot{.width = size, .height = size, .ramp = {}, .camera = &camera};
  shot.options.mode = BCCSPLAT_MODE_XRAY;
  const std::vector<float> got = picture(device, slice, shot);
  Bound bound("length of a ray in a cube, relative", 1e-3);
  for (uint32_t y = 0; y < size; ++y)
    for (uint32_t x = 0; x < size; ++x) {
      double begin = -1e9, end = 1e9;
      for (size_t a = 0; a < 3; ++a) {
        const double at = view.target[a] + (x + 0.5 - 0.5 * size) * view.pixel * view.right[a] -
                          (y + 0.5 - 0.5 * size) * view.pixel * view.up[a];
        const double one = -at / view.forward[a], two = (n - 1 - at) / view.forward[a];
        begin = std::max(begin, std::min(one, two)), end = std::min(end, std::max(one, two));
      }
      if (end - begin > 100) bound.add(got[(size_t{y} * size + x) * 4] / (end - begin) - 1);
    }
}

} // namespace
} // namespace host
