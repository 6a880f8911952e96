// SPDX-License-Identifier: Apache-2.0
// Several quantities of one volume in one picture: colours by another channel, labels and what they mask, and
// light that the volume stands in the way of. All against integrals that are written out here.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "support.h"

namespace host {
namespace {

using SceneHandle = Handle<bccsplat_scene>;
using Position = std::array<double, 3>;

constexpr uint32_t side = 33;     // samples
constexpr double last = side - 1; // of them
constexpr double middle = last / 2;
constexpr uint32_t pixels = 33; // one for each sample: pixel (i, j) looks at x = i, y = last - j
constexpr double none = 1e-6;

// A ball of density, a temperature that rises along x, three labels in layers along x.
double density(double x, double y, double z) {
  return 10 *
         std::exp(-((x - middle) * (x - middle) + (y - middle) * (y - middle) + (z - middle) * (z - middle)) /
                  60);
}
double temperature(double x, double, double) { return x; }
constexpr double first_border = 10.5, second_border = 21.5;
double label(double x, double, double) { return x < first_border ? 0 : x < second_border ? 3 : 7; }

class Quantities : public testing::Test {
 protected:
  Quantities() {
    write(folder.file("q.bcc4"), 0);
    volume = open(device, folder.file("q.bcc4"));
    options.shading = BCCSPLAT_SHADING_OFF, options.opacity_stop = 1;
    options.quality = BCCSPLAT_QUALITY_FINE;
    camera.projection = BCCSPLAT_PROJECTION_ORTHOGRAPHIC, camera.ortho_height = pixels;
    look_along_z();
  }
  void write(const std::string& path, uint32_t levels) const {
    std::array<bccsplat_channel_options, 3> channels{};
    const std::array<const char*, 3> names{"density", "temperature", "label"};
    for (size_t n = 0; n < 3; ++n)
      channels[n] = sized<bccsplat_channel_options>(), channels[n].name = names[n];
    channels[2].source_type = channels[2].value_type = BCCSPLAT_TYPE_U8;
    Series s;
    s.nx = s.ny = s.nz = side, s.nt = 3;
    auto o = options_of(s);
    o.lattice = BCCSPLAT_LATTICE_CC, o.levels = levels;
    o.channels = channels.data(), o.channel_count = 3;
    const Writer w = make_writer(device, path, o);
    const std::array<std::function<double(double, double, double)>, 3> fields{density, temperature, label};
    for (uint32_t c = 0; c < 3; ++c) {
      s.field = [&](double x, double y, double z, double) { return fields[c](x, y, z); };
      EXPECT_OK(add_frames(w.get(), s, c));
    }
    EXPECT_OK(bccsplat_writer_finish(w.get(), nullptr));
  }
  void look_along_z() {
    for (size_t a = 0; a < 2; ++a) camera.position[a] = camera.target[a] = middle;
    camera.position[2] = 200, camera.target[2] = 0; // against z: x to the right
    camera.up[0] = camera.up[2] = 0, camera.up[1] = 1;
  }
  // A function of opacities per unit length.
  static bccsplat_transfer_function function(const std::vector<double>& colors,
                                             const std::vector<double>& opacities) {
    auto f = sized<bccsplat_transfer_function>();
    f.colors = colors.data(), f.color_count = static_cast<uint32_t>(colors.size() / 4);
    f.opacities = opacities.data(), f.opacity_count = static_cast<uint32_t>(opacities.size() / 2);
    f.unit_distance = 1;
    return f;
  }
  bccsplat_status render(const bccsplat_instance& i, std::vector<float>& rgba,
                         const bccsplat_lights* lights = nullptr) const {
    bccsplat_scene* created = nullptr;
    EXPECT_OK(bccsplat_scene_create(device.get(), &created));
    const SceneHandle scene(created);
    uint64_t id = 0;
    if (const bccsplat_status s = bccsplat_scene_add(created, volume.get(), &i, &id); s != BCCSPLAT_OK)
      return s;
    if (lights) {
      EXPECT_OK(bccsplat_scene_set_lights(created, lights));
    }
    EXPECT_OK(bccsplat_scene_set_time(created, 1));
    rgba.assign(size_t{4} * pixels * pixels, 0);
    bccsplat_frame* f = nullptr;
    EXPECT_OK(bccsplat_frame_wrap(device.get(), pixels, pixels, rgba.data(), 0, &f));
    const Frame frame(f);
    auto view = sized<bccsplat_view>();
    view.camera = &camera;
    return bccsplat_scene_render(created, &view, f, &options, 0, nullptr);
  }
  [[nodiscard]] std::vector<float> draw(const bccsplat_instance& i,
                                        const bccsplat_lights* lights = nullptr) const {
    std::vector<float> rgba;
    EXPECT_OK(render(i, rgba, lights));
    return rgba;
  }
  static float at(const std::vector<float>& rgba, uint32_t i, uint32_t j, uint32_t part) {
    return rgba[4 * (size_t{j} * pixels + i) + part];
  }
  static double y_of(uint32_t j) { return last - j; }

  // What a ray against z gathers: extinction and emission at places, as far as the volume goes.
  struct Gathered {
    double color = 0, alpha = 0;
  };
  static Gathered gather(double x, double y, const std::function<double(const Position&)>& extinction,
                         const std::function<double(const Position&)>& emission) {
    constexpr int steps = 1600;
    const double h = last / steps;
    Gathered out;
    double through = 1;
    for (int n = 0; n < steps; ++n) {
      const Position p{x, y, last - (n + 0.5) * h};
      const double a = 1 - std::exp(-extinction(p) * h);
      out.color += through * a * emission(p), through *= 1 - a;
    }
    out.alpha = 1 - through;
    return out;
  }

  Folder folder;
  Device device = make_device();
  Volume volume;
  bccsplat_camera camera = sized<bccsplat_camera>();
  bccsplat_render_options options = sized<bccsplat_render_options>();
  // Density: white, opacity from 0 at 0 to 0.3 at 10. Temperature: red from 0 to 1.
  std::vector<double> white{0, 1, 1, 1}, rising{0, 0, 10, 0.3}, red{0, 0, 0, 0, last, 1, 0, 0};
  static double extinction_of(double value) { return -std::log(1 - 0.03 * std::clamp(value, 0.0, 10.0)); }
};

TEST_F(Quantities, OpacityByOneChannelColourByAnother) {
  const auto of_density = function(white, rising), of_temperature = function(red, rising);
  auto i = sized<bccsplat_instance>();
  i.transfer_function = &of_density;
  const std::vector<float> alone = draw(i);
  i.set_mask = BCCSPLAT_INSTANCE_SET_COLOR_CHANNEL, i.color_channel = 1, i.color_function = &of_temperature;
  const std::vector<float> painted = draw(i);
  for (uint32_t y = 1; y < pixels - 1; y += 3)
    for (uint32_t x = 1; x < pixels - 1; x += 3) {
      const Gathered expected = gather(
          x, y_of(y), [](const Position& p) { return extinction_of(density(p[0], p[1], p[2])); },
          [](const Position& p) { return temperature(p[0], p[1], p[2]) / last; });
      EXPECT_NEAR(at(painted, x, y, 0), expected.color, 4e-3) << x << " " << y;
      EXPECT_NEAR(at(painted, x, y, 3), expected.alpha, 4e-3) << x << " " << y;
      EXPECT_NEAR(at(painted, x, y, 3), at(alone, x, y, 3), 2e-3) << x << " " << y;
      EXPECT_EQ(at(painted, x, y, 1), 0);
    }
  // Along x the colour changes on the way: what is in front hides what is behind.
  camera.position[0] = -200, camera.target[0] = 0;
  camera.position[1] = camera.target[1] = camera.position[2] = camera.target[2] = middle;
  const std::vector<float> side_on = draw(i);
  const double h = last / 1600;
  double through = 1, color = 0;
  for (int n = 0; n < 1600; ++n) {
    const double x = (n + 0.5) * h, a = 1 - std::exp(-extinction_of(density(x, middle, middle)) * h);
    color += through * a * x / last, through *= 1 - a;
  }
  EXPECT_NEAR(at(side_on, pixels / 2, pixels / 2, 0), color, 4e-3);
}

TEST_F(Quantities, ASurfaceHasTheColoursOfAnotherChannel) {
  const auto of_density = function(white, rising), of_temperature = function(red, rising);
  auto i = sized<bccsplat_instance>();
  i.transfer_function = &of_density;
  i.set_mask = BCCSPLAT_INSTANCE_SET_COLOR_CHANNEL, i.color_channel = 1, i.color_function = &of_temperature;
  options.mode = BCCSPLAT_MODE_ISOSURFACE, options.set_mask = BCCSPLAT_RENDER_SET_ISO, options.iso_value = 5;
  const std::vector<float> surface = draw(i);
  int hits = 0;
  for (uint32_t y = 0; y < pixels; ++y)
    for (uint32_t x = 0; x < pixels; ++x) {
      if (at(surface, x, y, 3) < 1) continue;
      ++hits;
      EXPECT_NEAR(at(surface, x, y, 0), x / last, 8e-3) << x << " " << y;
      EXPECT_EQ(at(surface, x, y, 2), 0);
    }
  EXPECT_GT(hits, 100);
}

TEST_F(Quantities, ModesWithoutColoursAreRefusedByName) {
  auto i = sized<bccsplat_instance>();
  i.set_mask = BCCSPLAT_INSTANCE_SET_COLOR_CHANNEL, i.color_channel = 1;
  std::vector<float> rgba;
  options.mode = BCCSPLAT_MODE_XRAY;
  EXPECT_EQ(render(i, rgba), BCCSPLAT_ERROR_UNSUPPORTED);
  EXPECT_NE(std::string(bccsplat_last_error()).find("X-ray"), std::string::npos) << bccsplat_last_error();
  options.mode = BCCSPLAT_MODE_MAXIMUM;
  EXPECT_EQ(render(i, rgba), BCCSPLAT_ERROR_UNSUPPORTED);
  i.color_channel = 9, options.mode = BCCSPLAT_MODE_COMPOSITE;
  EXPECT_EQ(render(i, rgba), BCCSPLAT_ERROR_NOT_FOUND);
  i.set_mask = 64;
  EXPECT_EQ(render(i, rgba), BCCSPLAT_ERROR_INVALID_ARGUMENT);
  // A host of an earlier header knows nothing of all that.
  i.struct_size = offsetof(bccsplat_instance, set_mask);
  EXPECT_EQ(render(i, rgba), BCCSPLAT_OK);
}

TEST_F(Quantities, LabelsAreThoseOfTheNearestSample) {
  const std::vector<std::array<double, 4>> points{
      {10.4, 5, 5, 1}, {10.6, 5.3, 5, 1.4}, {21.4, 7, 7.7, 0.2}, {21.6, 7, 7, 1}, {0, 0, 0, 0}};
  std::vector<float> values(points.size()), gradients(4 * points.size());
  ASSERT_OK(bccsplat_volume_evaluate_channel(volume.get(), 2, points.size(), points[0].data(), values.data(),
                                             gradients.data()));
  EXPECT_EQ(values, (std::vector<float>{0, 3, 3, 7, 0}));
  for (const float g : gradients) EXPECT_EQ(g, 0);
  // Slices between frames, and across time.
  auto o = sized<bccsplat_slice_options>();
  o.channel = 2;
  for (const auto& [a, d, e] : {std::array<double, 3>{0, 1, -0.6}, {1, 0, -10.7}}) {
    auto plane = sized<bccsplat_hyperplane>();
    plane.a = a, plane.d = d, plane.e = e;
    bccsplat_slice* created = nullptr;
    ASSERT_OK(bccsplat_slice_create(volume.get(), &plane, &o, &created));
    const Slice slice(created);
    auto info = sized<bccsplat_slice_info>();
    ASSERT_OK(bccsplat_slice_get_info(created, &info));
    EXPECT_EQ(info.hyperplane[4], std::round(e)) << "through the nearest samples";
    auto grid = sized<bccsplat_grid>();
    for (size_t n = 0; n < 3; ++n) {
      grid.origin[n] = info.extent[n][0], grid.step[n] = 0.25;
      grid.dims[n] = static_cast<uint64_t>(4 * (info.extent[n][1] - info.extent[n][0])) + 1;
    }
    std::vector<float> sampled(grid.dims[0] * grid.dims[1] * grid.dims[2]);
    ASSERT_OK(bccsplat_slice_sample_grid(created, &grid, sampled.data()));
    for (size_t n = 0; n < sampled.size(); ++n) {
      const double x = a != 0 ? 11 : 0.25 * static_cast<double>(n % grid.dims[0]);
      const double nearest = std::floor(x + 0.5);
      ASSERT_EQ(sampled[n], static_cast<float>(label(nearest, 0, 0))) << n << " of plane " << a;
    }
  }
}

TEST_F(Quantities, LabelsStandAtSamplesWhereverABoxEnds) {
  auto plane = sized<bccsplat_hyperplane>();
  plane.d = 1, plane.e = -1;
  auto o = sized<bccsplat_slice_options>();
  const std::array<double, 6> box{8.6, 4.3, 5, 23.1, 7.7, 5};
  o.channel = 2, o.box = box.data();
  bccsplat_slice* created = nullptr;
  ASSERT_OK(bccsplat_slice_create(volume.get(), &plane, &o, &created));
  const Slice slice(created);
  auto info = sized<bccsplat_slice_info>();
  ASSERT_OK(bccsplat_slice_get_info(created, &info));
  for (size_t a = 0; a < 3; ++a) {
    EXPECT_NEAR(info.extent[a][0], box[a], 1e-9);
    EXPECT_NEAR(info.extent[a][1], box[a + 3], 1e-9);
  }
  for (double x = box[0]; x < box[3]; x += 0.07) {
    const std::array<double, 3> uvw{x, 5.5, 5};
    float value = 0;
    ASSERT_OK(bccsplat_slice_evaluate(created, 1, uvw.data(), &value, nullptr));
    EXPECT_EQ(value, static_cast<float>(label(std::floor(x + 0.5), 0, 0))) << x;
  }
  // What a ray meets of labels is the one behind the border.
  auto ray = sized<bccsplat_ray>();
  ray.pick = BCCSPLAT_PICK_VALUE, ray.threshold = 1;
  ray.origin[0] = -5, ray.origin[1] = 5.5, ray.origin[2] = 5, ray.direction[0] = 1;
  auto hit = sized<bccsplat_hit>();
  ASSERT_OK(bccsplat_slice_pick(created, &ray, &hit));
  EXPECT_EQ(hit.value, 3);
  EXPECT_NEAR(hit.world[0], first_border, 1e-3);
}

TEST_F(Quantities, PicturesOfLabelsMixNoColours) {
  // Each label has a colour of its own, and so have the values between them, which are of no label.
  const std::vector<double> colors{0, 0, 0,   0, 2.4, 0, 1,   0, 2.5, 1, 0,   0, 3.5, 1,
                                   0, 0, 3.6, 0, 1,   0, 6.4, 0, 1,   0, 6.5, 0, 0,   1};
  const std::vector<double> opacities{0, 0, 1, 0, 1, 0.2, 7, 0.2};
  const auto f = function(colors, opacities);
  auto i = sized<bccsplat_instance>();
  i.channel = 2, i.transfer_function = &f;
  const std::vector<float> rgba = draw(i);
  for (uint32_t y = 1; y < pixels - 1; ++y)
    for (uint32_t x = 1; x < pixels - 1; ++x) {
      const double l = label(x, 0, 0), alpha = l > 0 ? 1 - std::pow(0.8, last) : 0;
      EXPECT_NEAR(at(rgba, x, y, 3), alpha, 1e-3) << x;
      EXPECT_EQ(at(rgba, x, y, 1), 0) << x;
      EXPECT_NEAR(at(rgba, x, y, 0), l == 3 ? at(rgba, x, y, 3) : 0, 1e-4) << x;
      EXPECT_NEAR(at(rgba, x, y, 2), l == 7 ? at(rgba, x, y, 3) : 0, 1e-4) << x;
    }
}

// Nor beside a trail, of which nothing shows here.
TEST_F(Quantities, PicturesOfLabelsWithATrailMixNoColours) {
  const std::vector<double> opacities{3.5, 0, 3.6, 1, 6.4, 1, 6.5, 0}, nothing{0, 0};
  const auto between = function(white, opacities), clear = function(white, nothing);
  auto trail = sized<bccsplat_trail>();
  trail.interval[0] = -1, trail.transfer_function = &clear;
  options.preintegrate = BCCSPLAT_PREINTEGRATE_ON;
  camera.position[0] = 200, camera.target[0] = 0, camera.position[2] = camera.target[2] = middle;
  auto i = sized<bccsplat_instance>();
  i.channel = 2, i.transfer_function = &between, i.trail = &trail;
  for (const int32_t combine : {BCCSPLAT_TRAIL_PHYSICAL, BCCSPLAT_TRAIL_INTERLEAVED}) {
    trail.combine = combine;
    for (const float v : draw(i)) ASSERT_EQ(v, 0) << combine;
  }
}

TEST_F(Quantities, SmallPicturesMixNoColoursOfLabels) {
  const std::vector<double> colors{0, 1, 0, 0, 0.4, 1, 0, 0, 0.5, 0, 1, 0, 2.5, 0, 1, 0, 2.6, 0, 0, 1,
                                   3, 0, 0, 1, 3.4, 0, 0, 1, 3.5, 0, 1, 0, 6.5, 0, 1, 0, 6.6, 1, 0, 0};
  const auto f = function(white, rising), of_labels = function(colors, rising);
  auto i = sized<bccsplat_instance>();
  i.transfer_function = &f;
  i.set_mask = BCCSPLAT_INSTANCE_SET_COLOR_CHANNEL, i.color_channel = 2, i.color_function = &of_labels;
  options.quality = BCCSPLAT_QUALITY_NORMAL;
  camera.ortho_height = 4 * pixels; // a coarser slice is drawn
  for (const int32_t mode : {BCCSPLAT_MODE_COMPOSITE, BCCSPLAT_MODE_ISOSURFACE}) {
    options.mode = mode, options.set_mask = BCCSPLAT_RENDER_SET_ISO, options.iso_value = 3;
    for (const double aside : {-1.0, 0.0, 1.0, 2.0}) {
      camera.position[0] = camera.target[0] = middle + aside;
      const std::vector<float> rgba = draw(i);
      std::array<double, 4> sum{};
      for (size_t n = 0; n < rgba.size(); ++n) sum[n % 4] += rgba[n];
      EXPECT_EQ(sum[1], 0) << mode << ' ' << aside;
      EXPECT_NEAR(sum[0] + sum[2], sum[3], 1e-3) << mode << ' ' << aside;
      EXPECT_GT(sum[3], 5) << mode << ' ' << aside;
    }
  }
}

TEST_F(Quantities, LabelsMaskAnotherChannel) {
  const auto f = function(white, rising);
  auto i = sized<bccsplat_instance>();
  i.transfer_function = &f;
  const std::array<double, 2> shown{3, 7};
  for (const int32_t mode : {BCCSPLAT_MODE_COMPOSITE, BCCSPLAT_MODE_ISOSURFACE, BCCSPLAT_MODE_XRAY}) {
    options.mode = mode, options.set_mask = BCCSPLAT_RENDER_SET_ISO, options.iso_value = 5;
    options.smooth_edges = BCCSPLAT_SMOOTH_EDGES_OFF;
    i.set_mask = 0;
    const std::vector<float> whole = draw(i);
    i.set_mask = BCCSPLAT_INSTANCE_SET_MASK_CHANNEL, i.mask_channel = 2;
    i.mask_labels = shown.data(), i.mask_label_count = 1;
    const std::vector<float> one = draw(i);
    i.mask_label_count = 2;
    const std::vector<float> two = draw(i);
    for (uint32_t y = 0; y < pixels; ++y)
      for (uint32_t x = 0; x < pixels; ++x) {
        const double l = label(x, 0, 0);
        EXPECT_NEAR(at(one, x, y, 0), l == 3 ? at(whole, x, y, 0) : 0, 2e-3) << mode << ": " << x << " " << y;
        EXPECT_NEAR(at(two, x, y, 0), l > 0 ? at(whole, x, y, 0) : 0, 2e-3) << mode << ": " << x << " " << y;
      }
  }
  i.mask_label_count = 0; // none is shown
  options.mode = BCCSPLAT_MODE_COMPOSITE;
  for (const float v : draw(i)) EXPECT_EQ(v, 0);
  i.mask_label_count = 1, i.mask_labels = nullptr;
  std::vector<float> rgba;
  EXPECT_EQ(render(i, rgba), BCCSPLAT_ERROR_INVALID_ARGUMENT);
}

// Masks are read of level 0, at the frame nearest to the time, whatever level is drawn.
TEST_F(Quantities, PrefetchReadsTheMaskThatIsDrawn) {
  const auto f = function(white, rising);
  const std::array<double, 1> shown{3};
  auto i = sized<bccsplat_instance>();
  i.transfer_function = &f;
  i.set_mask = BCCSPLAT_INSTANCE_SET_MASK_CHANNEL, i.mask_channel = 2;
  i.mask_labels = shown.data(), i.mask_label_count = 1;
  options.quality = BCCSPLAT_QUALITY_NORMAL;
  constexpr uint32_t few = 8; // pixels, of a coarser level
  const Folder own;
  write(own.file("levels.bcc4"), 2);
  const Volume levels = open(device, own.file("levels.bcc4"));
  bccsplat_scene* created = nullptr;
  ASSERT_OK(bccsplat_scene_create(device.get(), &created));
  const SceneHandle scene(created);
  uint64_t id = 0;
  ASSERT_OK(bccsplat_scene_add(created, levels.get(), &i, &id));
  ASSERT_OK(bccsplat_scene_set_time(created, 1.3));
  auto view = sized<bccsplat_view>();
  view.camera = &camera;
  ASSERT_OK(bccsplat_scene_prefetch(created, &view, few, few, &options, 1.3));
  bccsplat_frame* made = nullptr;
  ASSERT_OK(bccsplat_frame_create(device.get(), few, few, 0, &made));
  const Frame frame(made);
  auto status = sized<bccsplat_scene_status>();
  ASSERT_OK(bccsplat_scene_render(created, &view, made, &options, 0, &status));
  EXPECT_GT(status.level, 0u);
  EXPECT_EQ(status.bytes_read, 0u);
}

// Light that comes along x and no other: diffuse alone, on what has no surface.
class Shadows : public Quantities {
 protected:
  Shadows() {
    options.shading = BCCSPLAT_SHADING_ON;
    options.set_mask = BCCSPLAT_RENDER_SET_GRADIENT_NOISE, options.gradient_noise = 1e6;
    lights.count = 1, lights.lights = &along_x;
    lights.diffuse = 1, lights.shininess = 1;
  }
  static double through(const Position& p, const Position& direction,
                        const std::function<double(const Position&)>& extinction) {
    constexpr double step = 0.05;
    const double length = std::hypot(direction[0], direction[1], direction[2]);
    double depth = 0;
    for (double s = step / 2;; s += step) {
      Position q;
      for (size_t a = 0; a < 3; ++a) q[a] = p[a] + s * direction[a] / length;
      if (std::any_of(q.begin(), q.end(), [](double v) { return v < 0 || v > last; })) break;
      depth += extinction(q) * step;
    }
    return std::exp(-depth);
  }
  static double ball(const Position& p) { return extinction_of(density(p[0], p[1], p[2])); }
  bccsplat_light along_x{{1, 0, 0}, {1, 1, 1}};
  bccsplat_lights lights = sized<bccsplat_lights>();
};

TEST_F(Shadows, LightIsWhatComesThrough) {
  const auto f = function(white, rising);
  auto i = sized<bccsplat_instance>();
  i.transfer_function = &f;
  const std::vector<float> unshadowed = draw(i, &lights);
  EXPECT_EQ(draw(i, &lights), unshadowed);
  lights.shadow = 1;
  double darkest = 1;
  for (const Position& towards : {Position{1, 0, 0}, {-1, 0.4, 0.3}, {0.2, -0.5, 1}}) {
    for (size_t a = 0; a < 3; ++a) along_x.direction[a] = towards[a];
    const std::vector<float> shadowed = draw(i, &lights);
    for (uint32_t y = 1; y < pixels - 1; y += 5)
      for (uint32_t x = 1; x < pixels - 1; x += 5) {
        const double yy = y_of(y);
        const Gathered plain = gather(x, yy, ball, [](const Position&) { return 1.0; });
        EXPECT_NEAR(at(unshadowed, x, y, 0), plain.color, 4e-3) << x << " " << y;
        if (plain.alpha < 0.02) continue;
        // A coarse integral of an integral.
        double sum = 0, left = 1;
        constexpr int steps = 128;
        for (int n = 0; n < steps; ++n) {
          const Position p{static_cast<double>(x), yy, last - (n + 0.5) * last / steps};
          const double a = 1 - std::exp(-ball(p) * last / steps);
          sum += left * a * through(p, towards, ball), left *= 1 - a;
        }
        EXPECT_NEAR(at(shadowed, x, y, 0), sum, 0.02) << x << " " << y;
        EXPECT_NEAR(at(shadowed, x, y, 3), at(unshadowed, x, y, 3), none);
        darkest = std::min(darkest, sum / plain.color);
      }
  }
  EXPECT_LT(darkest, 0.3) << "there is a shadow";
}

// A light at the camera shines along the ray of the whole picture's middle, whichever part is drawn.
TEST_F(Shadows, OfALightAtTheCameraAreThoseOfTheWholePicture) {
  const auto f = function(white, rising);
  auto i = sized<bccsplat_instance>();
  i.transfer_function = &f;
  lights = sized<bccsplat_lights>();
  lights.shadow = 1;
  bccsplat_scene* created = nullptr;
  ASSERT_OK(bccsplat_scene_create(device.get(), &created));
  const SceneHandle scene(created);
  uint64_t id = 0;
  ASSERT_OK(bccsplat_scene_add(created, volume.get(), &i, &id));
  ASSERT_OK(bccsplat_scene_set_lights(created, &lights));
  ASSERT_OK(bccsplat_scene_set_time(created, 1));
  camera.projection = BCCSPLAT_PROJECTION_PERSPECTIVE, camera.fovy_degrees = 70, camera.position[2] = 60;
  auto view = sized<bccsplat_view>();
  view.camera = &camera;
  constexpr uint32_t wide = 64, high = 48, half = high / 2;
  const auto drawn = [&](uint32_t rows) {
    std::vector<float> rgba(size_t{4} * wide * rows);
    bccsplat_frame* made = nullptr;
    EXPECT_OK(bccsplat_frame_wrap(device.get(), wide, rows, rgba.data(), 0, &made));
    const Frame frame(made);
    EXPECT_OK(bccsplat_scene_render(created, &view, made, &options, 0, nullptr));
    return rgba;
  };
  const std::vector<float> whole = drawn(high);
  view.picture_size[0] = wide, view.picture_size[1] = high;
  for (const uint32_t begin : {0u, half}) {
    view.region_begin[1] = begin;
    const std::vector<float> part = drawn(half);
    for (size_t n = 0; n < part.size(); ++n)
      ASSERT_NEAR(part[n], whole[size_t{4} * wide * begin + n], 1e-4) << begin << ' ' << n;
  }
}

TEST_F(Shadows, AmbientLightComesFromAllAround) {
  const auto f = function(white, rising);
  auto i = sized<bccsplat_instance>();
  i.transfer_function = &f;
  lights.ambient = 1, lights.diffuse = 0, lights.occlusion = 1;
  const std::vector<float> rgba = draw(i, &lights);
  for (const uint32_t x : {4u, 10u, 16u, 23u}) {
    double sum = 0, left = 1;
    constexpr int steps = 64;
    for (int n = 0; n < steps; ++n) {
      const Position p{static_cast<double>(x), middle, last - (n + 0.5) * last / steps};
      double around = 0;
      for (int d = 0; d < 3; ++d)
        for (const double sign : {-1.0, 1.0}) {
          Position axis{};
          axis[static_cast<size_t>(d)] = sign;
          around += through(p, axis, ball) / 15;
        }
      for (int corner = 0; corner < 8; ++corner)
        around +=
            3.0 / 40 *
            through(p, {corner & 1 ? 1.0 : -1.0, corner & 2 ? 1.0 : -1.0, corner & 4 ? 1.0 : -1.0}, ball);
      const double a = 1 - std::exp(-ball(p) * last / steps);
      sum += left * a * around, left *= 1 - a;
    }
    EXPECT_NEAR(at(rgba, x, pixels / 2, 0), sum, 0.02) << x;
  }
  lights.occlusion = 2;
  bccsplat_scene* created = nullptr;
  ASSERT_OK(bccsplat_scene_create(device.get(), &created));
  const SceneHandle scene(created);
  EXPECT_EQ(bccsplat_scene_set_lights(created, &lights), BCCSPLAT_ERROR_INVALID_ARGUMENT);
}

TEST_F(Shadows, AreNotDrawnByTheReference) {
  auto i = sized<bccsplat_instance>();
  lights.shadow = 1, options.reference = 1;
  std::vector<float> rgba;
  EXPECT_EQ(render(i, rgba, &lights), BCCSPLAT_ERROR_UNSUPPORTED);
  EXPECT_NE(std::string(bccsplat_last_error()).find("shadow"), std::string::npos) << bccsplat_last_error();
}

} // namespace
} // namespace host
