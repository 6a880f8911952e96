// SPDX-License-Identifier: Apache-2.0
// Moments of series that are stored as wavelets, where layers are added as coefficients, against splines in
// time of the frames that the same file gives, in double precision.
#include "tests/stability/stability.h"

namespace host {
namespace {

constexpr uint32_t frames = 40; // the last slab is a short one
constexpr double full = 65535;

// Turns its sign with every frame in half of the box: layers cancel each other.
double alternating(double x, double y, double z, double t) {
  const double wave = std::sin(0.4 * x + 0.2 * y) * std::cos(0.3 * z);
  const bool odd = static_cast<int>(t) % 2 != 0;
  return 0.5 * full * (1 + (odd && x < 10 ? -1 : 1) * 0.98 * wave);
}
double far_away(double x, double y, double z, double t) {
  return 60000 + 5000 * std::sin(0.4 * x + 0.2 * y - 0.7 * t) * std::cos(0.3 * z);
}
double turning(double x, double y, double z, double t) {
  return 0.5 * full *
         (1 + 0.98 * std::sin(0.4 * x + 2 * std::numbers::pi / frames * 3 * t) * std::cos(0.3 * z + 0.2 * y));
}

// Coefficients of the quadratic spline through the frames of a site: sums of the powers of the pole either
// way.
class Spline {
 public:
  Spline(const std::vector<double>& samples, bool periodic)
      : n_(static_cast<int>(samples.size())), periodic_(periodic) {
    const double pole = std::sqrt(8.0) - 3;
    for (int i = 0; i < n_; ++i) {
      double sum = 0;
      for (int k = -40; k <= 40; ++k) sum += std::pow(pole, std::abs(k)) * samples[place(i + k)];
      c_.push_back(std::numbers::sqrt2 * sum);
    }
  }
  [[nodiscard]] double at(double t) const {
    const int first = static_cast<int>(std::floor(t)) - 1;
    double sum = 0;
    for (int i = first; i < first + 4; ++i) {
      const double d = std::fabs(t - i), beyond = std::max(0.0, 1.5 - d), inside = std::max(0.0, 0.5 - d);
      sum += (0.5 * beyond * beyond - 1.5 * inside * inside) * c_[place(i)];
    }
    return sum;
  }

 private:
  [[nodiscard]] size_t place(int i) const {
    const int turn = periodic_ ? n_ : 2 * (n_ - 1), at = ((i % turn) + turn) % turn;
    return static_cast<size_t>(at < n_ ? at : turn - at);
  }
  int n_;
  bool periodic_;
  std::vector<double> c_;
};

// Frames as they are read, one after the other.
std::vector<std::vector<float>> frames_of(const Volume& volume, size_t samples) {
  std::vector<std::vector<float>> read(frames, std::vector<float>(samples));
  for (uint32_t t = 0; t < frames; ++t)
    EXPECT_OK(bccsplat_volume_read_frame(volume.get(), 0, t, nullptr, nullptr, read[t].data()));
  return read;
}

TEST(StabilityMoments, SumsOfWaveletsAreSplinesOfTheirFrames) {
  struct Case {
    const char* name;
    Field field;
    bool periodic;
  };
  const Device device = make_device();
  for (const Case& c : {Case{"signs that alternate", alternating, false},
                        Case{"a base far away", far_away, false}, Case{"a periodic series", turning, true}}) {
    const Series s{.nx = 21, .ny = 18, .nz = 17, .nt = frames, .field = c.field};
    bccsplat_writer_options o = options_of(s);
    auto channel = sized<bccsplat_channel_options>();
    channel.value_type = BCCSPLAT_TYPE_U16, channel.set_mask = BCCSPLAT_CHANNEL_SET_RANGE;
    channel.range[1] = full;
    o.channels = &channel, o.channel_count = 1;
    constexpr double error = 20;
    o.lattice = BCCSPLAT_LATTICE_CC, o.store = BCCSPLAT_STORE_WAVELETS, o.wavelet_errors = &error;
    if (c.periodic) o.ends = BCCSPLAT_ENDS_PERIODIC;
    const Stored stored = store(device, s, o, "exact");
    const size_t samples = size_t{s.nx} * s.ny * s.nz;
    const auto read = frames_of(stored.volume, samples);
    std::vector<Spline> splines;
    for (size_t i = 0; i < samples; ++i) {
      std::vector<double> site;
      for (const auto& frame : read) site.push_back(frame[i]);
      splines.emplace_back(site, c.periodic);
    }
    Bound bound(std::string(c.name) + ", of the range", 4e-6);
    // Ends of the series, and slabs and their ends; a periodic one goes on behind its last frame.
    std::vector<double> moments{0, 1e-6, 0.3, 7.5, 20, 30.9, 32.25, 38.7, 39};
    if (c.periodic) moments.push_back(39.6);
    for (const double t : moments) {
      const std::vector<float> got = grid_of(cut_time(stored.volume, t));
      ASSERT_EQ(got.size(), samples);
      for (size_t i = 0; i < samples; ++i) bound.add((static_cast<double>(got[i]) - splines[i].at(t)) / full);
    }
  }
}

} // namespace
} // namespace host
