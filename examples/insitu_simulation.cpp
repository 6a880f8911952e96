// SPDX-License-Identifier: Apache-2.0
// insitu_simulation OUT.bcc4 [PICTURE.png]: two clusters of particles meet under their own gravity, and the
// solver hands its density to the lattice while it runs. There is no Cartesian grid anywhere: each layer of
// the D4* lattice says at which moment it is and where its sites are; the solver steps to that moment and
// sums the particles' kernels there. Then the file is opened and drawn, with a trail of the motion. It uses
// the public header only.
#include <bccsplat.hpp>

#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace bccsplat::client;
using Vec3 = std::array<double, 3>;

constexpr uint32_t size = 64, frames = 24; // domain [0, size-1]^3 voxels, frame numbers 0 .. frames-1
constexpr double radius = 4;               // of a particle's kernel, voxels
constexpr double softening = 3;            // of gravity, voxels
constexpr double longest_step = 0.25;      // frames

class Solver {
 public:
  explicit Solver(int count) : position_(static_cast<size_t>(count)), velocity_(position_.size()) {
    std::mt19937 random(1);
    std::normal_distribution<double> spread(0, 3.5);
    for (size_t i = 0; i < position_.size(); ++i) {
      const double side = i % 3 == 0 ? 1 : -0.5; // one cluster has half the mass of the other
      position_[i] = {31.5 + 17 * side + spread(random), 31.5 + 5 * side + spread(random),
                      31.5 + spread(random)};
      velocity_[i] = {-1.1 * side, 0.75 * side, 0.25 * side};
    }
    accelerate();
  }

  [[nodiscard]] double time() const { return time_; }

  // Advances by the leapfrog method in equal steps, the last of which ends at `time` (frames) exactly.
  void advance_to(double time) {
    const int steps = static_cast<int>(std::ceil((time - time_) / longest_step));
    for (int s = 0; s < steps; ++s) {
      const double dt = (time - time_) / (steps - s);
      kick(dt / 2);
      for (size_t i = 0; i < position_.size(); ++i)
        for (size_t a = 0; a < 3; ++a) position_[i][a] += dt * velocity_[i][a];
      accelerate();
      kick(dt / 2);
      time_ = s + 1 == steps ? time : time_ + dt;
    }
  }

  // Adds every particle's kernel (1 - r^2 / radius^2)^3 to the sites it reaches; samples[x + nx (y + ny z)].
  void sum_density(const bccsplat_layer_geometry& g, std::vector<float>& samples) const {
    for (const Vec3& p : position_) {
      std::array<int64_t, 3> begin{}, end{};
      for (size_t a = 0; a < 3; ++a) {
        begin[a] =
            std::max<int64_t>(0, static_cast<int64_t>(std::ceil((p[a] - radius - g.origin[a]) / g.step[a])));
        end[a] = std::min(g.dims[a],
                          static_cast<int64_t>(std::floor((p[a] + radius - g.origin[a]) / g.step[a])) + 1);
      }
      for (int64_t k = begin[2]; k < end[2]; ++k)
        for (int64_t j = begin[1]; j < end[1]; ++j)
          for (int64_t i = begin[0]; i < end[0]; ++i) {
            const double dx = g.origin[0] + g.step[0] * static_cast<double>(i) - p[0],
                         dy = g.origin[1] + g.step[1] * static_cast<double>(j) - p[1],
                         dz = g.origin[2] + g.step[2] * static_cast<double>(k) - p[2];
            const double near = 1 - (dx * dx + dy * dy + dz * dz) / (radius * radius);
            if (near > 0)
              samples[i + g.dims[0] * (j + g.dims[1] * k)] += static_cast<float>(near * near * near);
          }
    }
  }

 private:
  void kick(double dt) {
    for (size_t i = 0; i < position_.size(); ++i)
      for (size_t a = 0; a < 3; ++a) velocity_[i][a] += dt * acceleration_[i][a];
  }
  void accelerate() {
    acceleration_.assign(position_.size(), {});
    const double gravity = 50.0 / static_cast<double>(position_.size());
    for (size_t i = 0; i < position_.size(); ++i)
      for (size_t j = 0; j < i; ++j) {
        Vec3 d{};
        double square = softening * softening;
        for (size_t a = 0; a < 3; ++a) d[a] = position_[j][a] - position_[i][a], square += d[a] * d[a];
        const double pull = gravity / (square * std::sqrt(square));
        for (size_t a = 0; a < 3; ++a) acceleration_[i][a] += pull * d[a], acceleration_[j][a] -= pull * d[a];
      }
  }

  std::vector<Vec3> position_, velocity_, acceleration_; // voxels, frames
  double time_ = 0;
};

void simulate(const Device& device, const char* path) {
  auto channel = sized<bccsplat_channel_options>();
  channel.name = "density", channel.air_threshold = 1e-3;
  auto options = sized<bccsplat_writer_options>();
  options.dims[0] = options.dims[1] = options.dims[2] = size, options.dims[3] = frames;
  options.channels = &channel, options.channel_count = 1, options.overwrite = 1;
  const Writer writer = make(bccsplat_writer_create, device.get(), path, &options);

  Solver solver(600);
  std::vector<float> samples;
  auto g = sized<bccsplat_layer_geometry>();
  g.layer_count = 1;
  for (int64_t layer = 0; layer < g.layer_count; ++layer) {
    check(bccsplat_writer_get_layer_geometry(writer.get(), layer, &g));
    solver.advance_to(g.frame);
    samples.assign(g.dims[0] * g.dims[1] * g.dims[2], 0);
    solver.sum_density(g, samples);
    check(bccsplat_writer_add_layer(writer.get(), 0, layer, samples.data(), samples.size()));
  }
  auto report = sized<bccsplat_writer_report>();
  check(bccsplat_writer_finish(writer.get(), &report));
  std::printf("%lld layers, %.1f %% of %llu lattice sites kept; a grid would have %llu samples\n",
              static_cast<long long>(g.layer_count),
              100 * static_cast<double>(report.sites_kept) / static_cast<double>(report.sites_total),
              static_cast<unsigned long long>(report.sites_total),
              static_cast<unsigned long long>(report.cc_samples));
}

void draw(const Device& device, const char* path, const char* picture) {
  const Volume volume = make(bccsplat_volume_open_file, device.get(), path, nullptr);
  auto plane = sized<bccsplat_hyperplane>();
  plane.d = 1, plane.e = -0.6 * (frames - 1); // between two frames
  const Slice slice = make(bccsplat_slice_create, volume.get(), &plane, nullptr);
  const Renderer renderer = make(bccsplat_renderer_create, device.get());
  check(bccsplat_renderer_set_slice(renderer.get(), slice.get()));
  auto camera = sized<bccsplat_camera>();
  check(bccsplat_slice_fit_camera(slice.get(), BCCSPLAT_PROJECTION_ORTHOGRAPHIC, 20, 30, 512, 512, &camera));
  camera.ortho_height *= 0.5; // the box is mostly empty
  check(bccsplat_renderer_set_camera(renderer.get(), &camera));
  auto trail = sized<bccsplat_trail>();
  trail.interval[0] = -6;
  check(bccsplat_renderer_set_trail(renderer.get(), &trail));
  const Frame frame = make(bccsplat_frame_create, device.get(), 512u, 512u, BCCSPLAT_FRAME_RGBA);
  check(bccsplat_renderer_render(renderer.get(), frame.get()));
  auto image = sized<bccsplat_image_options>();
  image.overwrite = image.use_background = 1; // black
  check(bccsplat_frame_save_png(frame.get(), picture, &image));
}

} // namespace

int main(int argc, char** argv) {
  if (argc < 2 || argc > 3) {
    std::fprintf(stderr, "usage: insitu_simulation OUT.bcc4 [PICTURE.png]\n");
    return 2;
  }
  try {
    const Device device = make(bccsplat_device_create, nullptr);
    simulate(device, argv[1]);
    if (argc == 3) draw(device, argv[1], argv[2]);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 1;
  }
  return 0;
}
