// SPDX-License-Identifier: Apache-2.0
// Sums of weights, and prefilters on the inputs that suit them least.
#include "tests/stability/stability.h"

namespace host {
namespace {

const char* const kernels[] = {"fast", "default", "fine", "paper"};
// Largest ripples of a constant (tests/bench/notes/kernels.md); the paper's, cut off, is divided by the sum
// of an uncut one.
constexpr double ripples[] = {0.0095, 0.0024, 0.00075, 3e-3};

// 1 from x = 17 on and air before: of a series that is 1 everywhere readers take 1 for the base, and no
// weight is seen.
Series shelf(uint32_t ny, uint32_t nz, uint32_t nt) {
  return {.nx = 26, .ny = ny, .nz = nz, .nt = nt, .field = [](double x, double, double, double) {
            return 0.5 + 0.5 * std::tanh((x - 8) / 1.2);
          }};
}

TEST(StabilityWeights, EveryKernelReproducesAConstantBordersIncluded) {
  const Device device = make_device();
  const Series s = shelf(9, 7, 6);
  for (size_t k = 0; k < 4; ++k) {
    const Stored stored = store(device, s, kernels[k]);
    std::vector<double> points = random_points(s, 300);
    for (size_t i = 0; i < points.size(); i += 4) points[i] = 17 + 8 * points[i] / 25;
    for (const double x : {17.0, 25.0}) // corners and edges
      for (const double y : {0.0, 4.3, 8.0})
        for (const double t : {0.0, 2.2, 5.0}) points.insert(points.end(), {x, y, 0.0, t});
    Bound bound(kernels[k], ripples[k]);
    double most = 0;
    for (const float v : values_at(stored.volume, points))
      bound.add(static_cast<double>(v) - 1), most = larger(most, std::fabs(static_cast<double>(v) - 1));
    EXPECT_GT(most, 0.3 * ripples[k]) << kernels[k]; // it is the weights that are seen
  }
}

TEST(StabilityWeights, TheWeightsOfATimeSliceSumToOneAtEveryPhase) {
  const Device device = make_device();
  const Series s = shelf(6, 6, 9);
  for (size_t k = 0; k < 4; ++k) {
    const Stored stored = store(device, s, kernels[k]);
    float first = 0;
    // B-splines in time sum to 1 whatever the phase; linear weights of the paper as well.
    Bound bound(kernels[k], 3e-6);
    for (double frame = 0; frame <= 8; frame += 0.37) {
      const Slice slice = cut_time(stored.volume, frame);
      const double uvw[] = {21.3, 2.9, 3.1};
      float v = 0;
      ASSERT_OK(bccsplat_slice_evaluate(slice.get(), 1, uvw, &v, nullptr));
      if (frame == 0) first = v;
      bound.add(static_cast<double>(v) - first);
    }
    EXPECT_NE(first, 1.0f) << kernels[k]; // it is the weights that are seen
  }
}

TEST(StabilityPrefilter, WhiteNoiseComesBackAtTheSites) {
  // The prefilter inverts the kernel by a truncated series: what is missing, on the worst input it can have.
  const Device device = make_device();
  struct Noise {
    std::mt19937 random{3};
    std::vector<double> points;
    std::vector<float> values;
  } noise;
  bccsplat_writer_options o = options_of({.nx = 14, .ny = 13, .nz = 12, .nt = 11});
  MemoryFile file;
  const Writer writer = make_writer(device, file, o);
  bccsplat_writer* const w = writer.get();
  ASSERT_OK(bccsplat_writer_add_field(
      w, 0,
      [](void* user, uint64_t n, const double* xyzt, float* values) -> int32_t {
        auto& into = *static_cast<Noise*>(user);
        std::uniform_real_distribution<float> uniform(-1, 1);
        for (uint64_t i = 0; i < n; ++i) values[i] = uniform(into.random);
        into.points.insert(into.points.end(), xyzt, xyzt + 4 * n);
        into.values.insert(into.values.end(), values, values + n);
        return 0;
      },
      &noise));
  ASSERT_OK(bccsplat_writer_finish(w, nullptr));
  struct Case {
    const char* kernel;
    double most, rms; // of uniform noise in [-1, 1], 0.577 root mean square
  };
  for (const auto& [kernel, most, rms] :
       {Case{"fast", 0.35, 0.1}, Case{"default", 0.32, 0.07}, Case{"fine", 0.5, 0.09}}) {
    auto options = sized<bccsplat_volume_options>();
    options.kernel = kernel;
    bccsplat_volume* v = nullptr;
    ASSERT_OK(bccsplat_volume_open_memory(device.get(), file.bytes.data(), file.bytes.size(), &options, &v));
    const Volume volume(v);
    Bound bound(std::string(kernel) + ", noise of 1 at the sites", most);
    double square = 0;
    std::vector<float> got(noise.values.size());
    (void)bccsplat_volume_evaluate(v, got.size(), noise.points.data(), got.data(),
                                   nullptr); // some sites are outside
    size_t inside = 0;
    for (size_t i = 0; i < got.size(); ++i) {
      if (!std::isfinite(got[i])) continue;
      const double e = static_cast<double>(got[i]) - noise.values[i];
      bound.add(e), square += e * e, ++inside;
    }
    ASSERT_GT(inside, 2000u);
    Bound(std::string(kernel) + ", root mean square of the same", rms)
        .add(std::sqrt(square / static_cast<double>(inside)));
  }
}

TEST(StabilityPrefilter, SamplesComeBackFromTheHighestFrequencies) {
  // A checkerboard is at the corner of the cube, far outside the lattice's band: it must stay bounded by the
  // gain.
  const Device device = make_device();
  Series s{.nx = 16, .ny = 16, .nz = 16, .nt = 8};
  s.field = [](double x, double y, double z, double t) { return std::fmod(x + y + z + t, 2) == 0 ? 1 : -1; };
  for (const char* kernel : kernels) {
    const Stored stored = store(device, s, kernel);
    Bound bound(std::string(kernel) + ", checkerboard of 1, largest value", 1.5);
    double most = 0;
    for (const float v : values_at(stored.volume, random_points(s, 400)))
      bound.add(v), most = larger(most, std::fabs(v));
    EXPECT_GT(most, 0.4) << kernel;
  }
  // Nyquist of one axis alone is at the edge of the ball: attenuated or kept, never amplified by more than a
  // fifth.
  s.field = [](double x, double, double, double) { return std::fmod(x, 2) == 0 ? 1 : -1; };
  for (const char* kernel : kernels) {
    const Stored stored = store(device, s, kernel);
    Bound bound(std::string(kernel) + ", Nyquist of an axis, largest value", 1.25);
    double most = 0;
    for (const float v : values_at(stored.volume, random_points(s, 400)))
      bound.add(v), most = larger(most, std::fabs(v));
    EXPECT_GT(most, 0.45) << kernel;
  }
}

TEST(StabilityPrefilter, OneSampleStaysALocalBump) {
  const Device device = make_device();
  Series s{.nx = 21, .ny = 21, .nz = 21, .nt = 15};
  s.field = [](double x, double y, double z, double t) {
    return x == 10 && y == 10 && z == 10 && t == 7 ? 1000 : 0;
  };
  for (const char* kernel : {"default", "fine"}) {
    const Stored stored = store(device, s, kernel);
    const std::vector<double> at{10, 10, 10, 7}, far{1, 1, 1, 1, 19, 10, 10, 7, 10, 10, 10, 0};
    const float peak = values_at(stored.volume, at)[0];
    EXPECT_GT(peak, 100) << kernel; // half the samples carry half of what an impulse holds
    EXPECT_LT(peak, 1000) << kernel;
    Bound reach(std::string(kernel) + ", far from an impulse of 1000", 0.2);
    for (const float v : values_at(stored.volume, far)) reach.add(v);
    const std::vector<float> values = values_at(stored.volume, random_points(s, 2000));
    Bound ringing(std::string(kernel) + ", ringing of an impulse of 1000", 60);
    for (const float v : values) ringing.add(v > 0 ? 0 : v);
  }
}

} // namespace
} // namespace host
