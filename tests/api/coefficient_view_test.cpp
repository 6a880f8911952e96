// SPDX-License-Identifier: Apache-2.0
// What files of coefficients in whole steps show, beside what files of samples of the same steps show.
#include <iostream>
#include <random>

#include "support.h"

namespace host {
namespace {

// Waves inside the ball of half the frequencies that D4* holds, mean square 1.
class Waves {
 public:
  Waves() {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(-1, 1);
    while (waves_.size() < 12) {
      std::array<double, 5> w{};
      for (double& v : w) v = uniform(random);
      if (w[0] * w[0] + w[1] * w[1] + w[2] * w[2] + w[3] * w[3] > 1) continue;
      for (size_t a = 0; a < 4; ++a) w[a] *= 0.5 * pi;
      w[4] *= pi;
      waves_.push_back(w);
    }
  }
  [[nodiscard]] double at(const std::array<double, 4>& p) const {
    double sum = 0;
    for (const auto& w : waves_)
      sum += std::cos(w[0] * p[0] + w[1] * p[1] + w[2] * p[2] + w[3] * p[3] + w[4]);
    return std::sqrt(2.0 / static_cast<double>(waves_.size())) * sum;
  }

 private:
  static constexpr double pi = 3.14159265358979323846;
  std::vector<std::array<double, 5>> waves_;
};

// The same series of bytes in both stores.
class CoefficientView : public testing::Test {
 protected:
  // Writes `s` with values rounded to bytes, and opens what was written.
  [[nodiscard]] Volume stored(const Series& s, int32_t store) const {
    auto o = options_of(s);
    auto channel = sized<bccsplat_channel_options>();
    channel.value_type = BCCSPLAT_TYPE_U8;
    channel.set_mask = BCCSPLAT_CHANNEL_SET_RANGE;
    channel.range[1] = 255, channel.value_step = 1;
    o.channels = &channel, o.channel_count = 1, o.store = store, o.overwrite = 1;
    const std::string path = folder.file(store == BCCSPLAT_STORE_SAMPLES ? "samples" : "coefficients");
    const Writer w = make_writer(device, path, o);
    EXPECT_OK(add_frames(w.get(), s));
    EXPECT_OK(bccsplat_writer_finish(w.get(), nullptr));
    Volume volume = open(device, path);
    auto info = sized<bccsplat_channel_info>();
    EXPECT_OK(bccsplat_volume_get_channel_info(volume.get(), 0, &info));
    EXPECT_EQ(info.value_type, store == BCCSPLAT_STORE_SAMPLES ? BCCSPLAT_TYPE_U8 : BCCSPLAT_TYPE_I32);
    return volume;
  }

  const Folder folder;
  const Device device = make_device();
};

constexpr int32_t stores[] = {BCCSPLAT_STORE_SAMPLES, BCCSPLAT_STORE_COEFFICIENTS};

// Signal to error in dB of the slice across `axis`, away from the ends, against the waves before rounding.
double slice_db(const Volume& volume, const Waves& waves, size_t axis) {
  constexpr double place = 17.3;
  std::array<double, 4> normal{};
  normal[axis] = 1;
  const Slice slice = cut(volume, normal[0], normal[1], normal[2], normal[3], -place);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> inside(9, 26);
  std::vector<double> uvw, truth;
  for (int i = 0; i < 4000; ++i) {
    std::array<double, 4> p{};
    p[axis] = place;
    for (size_t a = 0; a < 4; ++a)
      if (a != axis) uvw.push_back(p[a] = inside(random));
    truth.push_back(30 * waves.at(p));
  }
  std::vector<float> values(truth.size());
  EXPECT_OK(bccsplat_slice_evaluate(slice.get(), values.size(), uvw.data(), values.data(), nullptr));
  double signal = 0, error = 0;
  for (size_t i = 0; i < truth.size(); ++i)
    signal += truth[i] * truth[i], error += std::pow(static_cast<double>(values[i]) - 128 - truth[i], 2);
  return 10 * std::log10(signal / error);
}

TEST_F(CoefficientView, SlicesAcrossEveryAxisAreAsNearToTheTruth) {
  const Waves waves;
  Series s;
  s.nx = s.ny = s.nz = s.nt = 36;
  s.field = [&](double x, double y, double z, double t) {
    return std::nearbyint(128 + 30 * waves.at({x, y, z, t}));
  };
  std::array<Volume, 2> volumes{stored(s, stores[0]), stored(s, stores[1])};
  for (size_t axis = 0; axis < 4; ++axis) {
    const double samples = slice_db(volumes[0], waves, axis),
                 coefficients = slice_db(volumes[1], waves, axis);
    std::cout << "xyzt"[axis] << " slice, dB: samples " << samples << ", coefficients " << coefficients
              << '\n';
    EXPECT_GT(coefficients, samples - 1) << axis;
    EXPECT_GT(coefficients, 38) << axis;
  }
}

std::vector<float> trail_picture(const Device& device, const Volume& volume, int32_t content) {
  const Slice slice = cut_time(volume, 20);
  bccsplat_renderer* r = nullptr;
  EXPECT_OK(bccsplat_renderer_create(device.get(), &r));
  const Renderer renderer(r);
  EXPECT_OK(bccsplat_renderer_set_slice(r, slice.get()));
  auto trail = sized<bccsplat_trail>();
  trail.interval[0] = -12, trail.content = content;
  EXPECT_OK(bccsplat_renderer_set_trail(r, &trail));
  const double colors[] = {0, 1, 0, 0, 200, 0, 1, 0}, opacities[] = {0, 0, 200, 0.25};
  auto function = sized<bccsplat_transfer_function>();
  function.color_count = function.opacity_count = 2;
  function.colors = colors, function.opacities = opacities;
  EXPECT_OK(bccsplat_renderer_set_transfer_function(r, &function));
  std::vector<float> rgba(size_t{96} * 96 * 4);
  bccsplat_frame* f = nullptr;
  EXPECT_OK(bccsplat_frame_wrap(device.get(), 96, 96, rgba.data(), 0, &f));
  const Frame frame(f);
  EXPECT_OK(bccsplat_renderer_render(r, f));
  return rgba;
}

TEST_F(CoefficientView, TrailsAreTheSamePicture) {
  Series s;
  s.nx = 40, s.ny = s.nz = 30, s.nt = 30;
  s.field = [](double x, double y, double z, double t) {
    const auto ball = [&](double cx, double cy, double cz, double r) {
      return std::exp(-(std::pow(x - cx, 2) + std::pow(y - cy, 2) + std::pow(z - cz, 2)) / (2 * r * r));
    };
    return std::nearbyint(200 * ball(6 + t, 15, 12, 2.5) + 120 * ball(20, 15 + 4 * std::sin(0.3 * t), 20, 4));
  };
  std::array<Volume, 2> volumes{stored(s, stores[0]), stored(s, stores[1])};
  for (const int32_t content : {BCCSPLAT_TRAIL_CLASSIFIED, BCCSPLAT_TRAIL_MEAN, BCCSPLAT_TRAIL_MAXIMUM}) {
    const auto a = trail_picture(device, volumes[0], content), b = trail_picture(device, volumes[1], content);
    double squares = 0, largest = 0, brightest = 0;
    for (size_t i = 0; i < a.size(); ++i) {
      const double d = std::fabs(static_cast<double>(a[i]) - b[i]);
      squares += d * d, largest = larger(largest, d);
      brightest = std::max(brightest, static_cast<double>(a[i]));
    }
    const double rms = std::sqrt(squares / static_cast<double>(a.size()));
    std::cout << "trail " << content << ": RMS " << rms << ", largest " << largest << " of " << brightest
              << '\n';
    EXPECT_GT(brightest, 0.3);
    EXPECT_LT(rms, 0.5 / 255);
    EXPECT_LT(largest, 5.0 / 255);
  }
}

} // namespace
} // namespace host
