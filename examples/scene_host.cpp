// SPDX-License-Identifier: Apache-2.0
// scene_host FILE.bcc4 OUT.png [TIME]: a program with a scene of its own that puts a volume into it.
//
// It ray-traces a floor, a ball and the edges of the volume's box into a picture and a depth plane, as a
// host's engine would rasterise them, hands both over with its matrices, and gets the volume in its scene:
// behind the ball, before the floor, cut open by a plane, for two eyes side by side.
#include <bccsplat.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <vector>

namespace {

using namespace bccsplat::client;

constexpr uint32_t width = 480, height = 480; // of each eye
using Point = std::array<double, 3>;

Point operator+(const Point& a, const Point& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Point operator-(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Point operator*(double s, const Point& a) { return {s * a[0], s * a[1], s * a[2]}; }
double dot(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Point normalised(const Point& a) { return 1 / std::sqrt(dot(a, a)) * a; }

// The host's own world around the volume's box.
struct Things {
  Point low, high; // the box
  Point ball;
  double radius, floor;

  explicit Things(const double (&box)[6]) : low{box[0], box[1], box[2]}, high{box[3], box[4], box[5]} {
    const Point size = high - low;
    radius = 0.09 * std::sqrt(dot(size, size));
    ball = low + Point{0.4 * size[0], 0.42 * size[1], 0.4 * size[2]};
    floor = low[1] - 0.02 * size[1];
  }
};

// One eye: its view, what it shows of the host's things, and at which distances along the view direction.
struct Eye {
  bccsplat_view view = sized<bccsplat_view>();
  std::vector<float> rgba = std::vector<float>(size_t{4} * width * height);
  std::vector<float> depth =
      std::vector<float>(size_t{width} * height, std::numeric_limits<float>::infinity());

  // Moves the camera sideways and shifts its frustum back, so that both eyes see the target in one place.
  Eye(const bccsplat_camera& camera, double sideways, double distance) {
    view.use_matrices = 1;
    check(bccsplat_camera_get_matrices(&camera, width, height, 0.01 * distance, 100 * distance,
                                       BCCSPLAT_DEPTH_RANGE_DEFAULT, 0, view.world_to_view, view.projection));
    view.world_to_view[3] -= sideways;
    view.projection[2] -= view.projection[0] * sideways / distance;
    view.depth = depth.data(), view.depth_kind = BCCSPLAT_DEPTH_PLANAR;
    view.background = rgba.data();
  }

  [[nodiscard]] Point unproject(double x, double y, double distance) const {
    const double pixel[3] = {x, y, distance};
    Point p;
    check(bccsplat_view_unproject(&view, width, height, 1, pixel, p.data()));
    return p;
  }
  void put(size_t pixel, double distance, const std::array<float, 3>& color) {
    if (!(distance > 0 && distance < depth[pixel])) return;
    depth[pixel] = static_cast<float>(distance);
    for (size_t c = 0; c < 3; ++c) rgba[4 * pixel + c] = color[c];
    rgba[4 * pixel + 3] = 1;
  }
};

// Rays run from distance 0 to distance 1 in `step`.
void draw_things(Eye& eye, const Things& things) {
  const Point light = normalised({-0.4, 1, -0.6});
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      const size_t pixel = size_t{width} * y + x;
      for (size_t c = 0; c < 4; ++c)
        eye.rgba[4 * pixel + c] = c == 3 ? 1 : 0.1f + 0.15f * static_cast<float>(y) / height;
      const Point from = eye.unproject(x + 0.5, y + 0.5, 0), step = eye.unproject(x + 0.5, y + 0.5, 1) - from;
      if (step[1] < 0) {
        const double at = (things.floor - from[1]) / step[1];
        const Point p = from + at * step;
        const double tile = 0.12 * (things.high[0] - things.low[0]);
        const bool dark =
            (static_cast<int>(std::floor(p[0] / tile)) + static_cast<int>(std::floor(p[2] / tile))) & 1;
        const Point middle = 0.5 * (things.low + things.high);
        if (std::hypot(p[0] - middle[0], p[2] - middle[2]) < 9 * tile)
          eye.put(pixel, at, dark ? std::array{0.05f, 0.06f, 0.08f} : std::array{0.35f, 0.35f, 0.33f});
      }
      const Point to = things.ball - from;
      const double a = dot(step, step), b = dot(step, to), c = dot(to, to) - things.radius * things.radius;
      if (b * b > a * c) {
        const double at = (b - std::sqrt(b * b - a * c)) / a;
        const Point normal = normalised(from + at * step - things.ball);
        const auto lit = static_cast<float>(0.15 + 0.85 * std::max(0.0, dot(normal, light)));
        eye.put(pixel, at, {0.8f * lit, 0.25f * lit, 0.1f * lit});
      }
    }
}

// The twelve edges of the box as points that lie close to each other.
void draw_box(Eye& eye, const Things& things) {
  const Point size = things.high - things.low;
  for (size_t axis = 0; axis < 3; ++axis)
    for (size_t corner = 0; corner < 4; ++corner) {
      const size_t second = (axis + 1) % 3, third = (axis + 2) % 3;
      for (int n = 0; n <= 4000; ++n) {
        Point p = things.low;
        p[axis] += size[axis] * n / 4000.0;
        if (corner & 1) p[second] += size[second];
        if (corner & 2) p[third] += size[third];
        double pixel[3];
        check(bccsplat_view_project(&eye.view, width, height, 1, p.data(), pixel));
        if (!(pixel[0] >= 0 && pixel[0] < width && pixel[1] >= 0 && pixel[1] < height)) continue;
        eye.put(size_t{width} * static_cast<size_t>(pixel[1]) + static_cast<size_t>(pixel[0]), pixel[2],
                {0.9f, 0.9f, 0.6f});
      }
    }
}

void draw(const char* file, const char* picture, const double* time) {
  const Device device = make(bccsplat_device_create, nullptr);
  const Volume volume = make(bccsplat_volume_open_file, device.get(), file, nullptr);
  const Scene scene = make(bccsplat_scene_create, device.get());
  uint64_t id = 0;
  check(bccsplat_scene_add(scene.get(), volume.get(), nullptr, &id));
  auto info = sized<bccsplat_volume_info>();
  check(bccsplat_volume_get_info(volume.get(), &info));
  check(bccsplat_scene_set_time(scene.get(), time ? *time : info.time_first));

  double box[6];
  check(bccsplat_scene_get_bounds(scene.get(), box));
  const Things things(box);
  auto camera = sized<bccsplat_camera>();
  check(bccsplat_scene_fit_camera(scene.get(), BCCSPLAT_PROJECTION_PERSPECTIVE, 20, 30, width, height,
                                  &camera));
  const Point away = Point{camera.position[0], camera.position[1], camera.position[2]} -
                     Point{camera.target[0], camera.target[1], camera.target[2]};
  const double distance = std::sqrt(dot(away, away));

  // What is nearest to the viewer is cut away.
  bccsplat_clip open{};
  const Point towards = normalised({away[0], 0, away[2]}), middle = 0.5 * (things.low + things.high);
  for (size_t a = 0; a < 3; ++a) open.normal[a] = -towards[a];
  open.offset = dot(towards, middle) + 0.12 * distance;
  check(bccsplat_scene_set_clips(scene.get(), &open, 1));

  const Frame both = make(bccsplat_frame_create, device.get(), 2 * width, height, 0u);
  auto plane = sized<bccsplat_plane>();
  check(bccsplat_frame_get_channel(both.get(), BCCSPLAT_FRAME_RGBA, &plane));
  for (const int side : {-1, 1}) {
    Eye eye(camera, side * 0.03 * distance, distance);
    draw_things(eye, things);
    draw_box(eye, things);
    float* const pixels = plane.pixels + (side < 0 ? 0 : size_t{4} * width);
    const Frame half = make(bccsplat_frame_wrap, device.get(), width, height, pixels, plane.row_bytes);
    auto status = sized<bccsplat_scene_status>();
    check(bccsplat_scene_render(scene.get(), &eye.view, half.get(), nullptr, 0, &status));
    std::printf("%s eye: level %u, %.1f ms to cut, %.1f ms to draw\n", side < 0 ? "left" : "right",
                status.level, status.ms_cut, status.ms_draw);
  }
  auto options = sized<bccsplat_image_options>();
  options.overwrite = 1;
  check(bccsplat_frame_save_png(both.get(), picture, &options));
}

} // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: scene_host FILE.bcc4 OUT.png [TIME]\n");
    return 2;
  }
  try {
    const double time = argc > 3 ? std::atof(argv[3]) : 0;
    draw(argv[1], argv[2], argc > 3 ? &time : nullptr);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 1;
  }
  return 0;
}
