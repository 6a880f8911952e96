// Sums of weights, and prefilters on the inputs that suit them least.
#include "tests/stability/stability.h"

namespace host {
namespace {

const char* const kernels[] = {"fast", "default", "fine", "paper"};
// Largest ripples of a constant (tests/bench/notes/kernels.md); the paper's, cut off, is divided by the sum
// of an uncut one.
constexpr double ripples[] = {0.0095, default_ripple, 0.00075, 3e-3};

TEST(StabilityWeights, EveryKernelReproducesAConstantBordersIncluded) {
  const Device device = make_device();
  const Series s{
      .nx = 11, .ny = 9, .nz = 7, .nt = 6, .field = [](double, double, double, double) { return 1; }};
  for (size_t k = 0; k < 4; ++k) {
    const Stored stored = store(device, s, kernels[k]);
    std::vector<double> points = random_points(s, 300);
    for (const double x : {0.0, 10.0}) // corners and edges
      for (const double y : {0.0, 4.3, 8.0})
        for (const double t : {0.0, 2.2, 5.0}) points.insert(points.end(), {x, y, 0.0, t});
    for (const float v : values_at(stored.volume, points)) ASSERT_NEAR(v, 1, ripples[k]) << kernels[k];
  }
}

TEST(StabilityWeights, TheWeightsOfATimeSliceSumToOneAtEveryPhase) {
  const Device device = make_device();
  const Series s{
      .nx = 6, .ny = 6, .nz = 6, .nt = 9, .field = [](double, double, double, double) { return 1; }};
  for (size_t k = 0; k < 4; ++k) {
    const Stored stored = store(device, s, kernels[k]);
    float first = 0;
    for (double frame = 0; frame <= 8; frame += 0.37) {
      const Slice slice = cut_time(stored.volume, frame);
      const double uvw[] = {2.3, 2.9, 3.1};
      float v = 0;
      ASSERT_OK(bccsplat_slice_evaluate(slice.get(), 1, uvw, &v, nullptr));
      if (frame == 0) first = v;
      // B-splines in time sum to 1 whatever the phase; linear weights of the paper as well.
      ASSERT_NEAR(v, first, 3e-6) << kernels[k] << ' ' << frame;
    }
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
    for (const float v : values_at(stored.volume, random_points(s, 400)))
      ASSERT_LE(std::abs(v), 1.5) << kernel;
  }
  // Nyquist of one axis alone is at the edge of the ball: attenuated or kept, never amplified by more than a
  // fifth.
  s.field = [](double x, double, double, double) { return std::fmod(x, 2) == 0 ? 1 : -1; };
  for (const char* kernel : kernels) {
    const Stored stored = store(device, s, kernel);
    for (const float v : values_at(stored.volume, random_points(s, 400)))
      ASSERT_LE(std::abs(v), 1.25) << kernel;
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
    for (const float v : values_at(stored.volume, far)) EXPECT_LE(std::abs(v), 5) << kernel;
    const std::vector<float> values = values_at(stored.volume, random_points(s, 2000));
    EXPECT_GT(*std::min_element(values.begin(), values.end()), -400) << kernel;
  }
}

} // namespace
} // namespace host
