// SPDX-License-Identifier: Apache-2.0
// How close values come to fields known everywhere, from samples to points: the figures users choose a kernel
// by. `bccsplat_bench kernels --chain --marschner` measures the same on larger fields.
#include <gtest/gtest.h>

#include <algorithm>

#include "field/coefficients/coefficients.h"
#include "field/evaluate.h"
#include "fit/fit.h"
#include "slice/time_slice.h"
#include "tests/support/band_limited.h"
#include "tests/support/dense_layer.h"
#include "tests/support/fields.h"

namespace bccsplat {
namespace {

using test::Grid4;
using test::large_cache;
using test::MarschnerLobb;
using test::PlaneWaves;
using test::random_points;
using test::TestContext;

constexpr uint32_t edge = 30; // samples per axis
constexpr double margin = 10; // from the ends, where a wave is not its own mirror image

struct KernelSnr {
  const char* kernel;
  std::array<double, 3> snr; // dB at rho 0.5, 0.7, 0.9
};
std::ostream& operator<<(std::ostream& out, const KernelSnr& a) { return out << a.kernel; }
constexpr std::array<double, 3> rhos{0.5, 0.7, 0.9};

double snr_db(const std::vector<float>& got, const std::vector<double>& truth) {
  double signal = 0, error = 0;
  for (size_t i = 0; i < got.size(); ++i) {
    const double e = got[i] - truth[i];
    signal += truth[i] * truth[i], error += e * e;
  }
  return 10 * std::log10(signal / error);
}

MemorySamples on_sites(const Lattice4& lattice, const PlaneWaves& field) {
  std::vector<std::vector<BrickLayer>> layers(1);
  for (int32_t m = 0; m < lattice.layers(); ++m) {
    const std::vector<double> v = field.on_grid(test::layer_grid(lattice, m));
    layers[0].push_back(
        test::layer_from_dense(lattice.space, lattice.coset(m), std::vector<float>(v.begin(), v.end())));
  }
  return {lattice, {0}, std::move(layers)};
}

// Lasts: coefficients hold memory of its budget.
const Context& context() {
  static TestContext parts;
  static const Context all = parts.get();
  return all;
}

std::vector<float> values_of(const Coefficients& c, const std::vector<Vec4>& points) {
  std::vector<float> values(points.size());
  (void)evaluate4(c, points, values, {}, context());
  return values;
}

class Direct : public testing::TestWithParam<KernelSnr> {};
INSTANTIATE_TEST_SUITE_P(EvaluateAccuracy, Direct,
                         testing::Values(KernelSnr{"default", {50, 34, 18.5}},
                                         KernelSnr{"fine", {62, 43, 21.5}}));

TEST_P(Direct, WavesSampledOnTheLattice) {
  const auto lattice = Lattice4::fit(LatticeKind::d4star, {edge, edge, edge, edge});
  const auto points = random_points(lattice, 1500, 19, margin);
  for (size_t r = 0; r < rhos.size(); ++r) {
    const PlaneWaves field(120, rhos[r], 17);
    std::vector<double> truth;
    for (const Vec4& p : points) truth.push_back(field(p));
    const MemorySamples samples = on_sites(lattice, field);
    EXPECT_GE(snr_db(values_of({samples, 0, make_kernel(GetParam().kernel), 0, large_cache}, points), truth),
              GetParam().snr[r])
        << "rho " << rhos[r];
  }
}

class Imported : public testing::TestWithParam<KernelSnr> {};
INSTANTIATE_TEST_SUITE_P(EvaluateAccuracy, Imported,
                         testing::Values(KernelSnr{"default", {47.5, 33, 17.5}},
                                         KernelSnr{"fine", {54, 41, 20.5}}));

TEST_P(Imported, SlicesBetweenFrames) {
  Grid4 frames, grid;
  for (auto& axis : frames)
    for (uint32_t i = 0; i < edge; ++i) axis.push_back(i);
  for (size_t a = 0; a < 3; ++a)
    for (double x = margin; x < edge - margin; ++x) grid[a].push_back(x);
  grid[3] = {margin + 0.13, margin + 1.5, margin + 2.71};
  for (size_t r = 0; r < rhos.size(); ++r) {
    const PlaneWaves field(120, rhos[r], 17);
    FitOptions options;
    options.dims = {edge, edge, edge, edge};
    std::vector<std::vector<BrickLayer>> layers(1);
    Fit fit(
        options,
        [&](int32_t, int, std::span<const BrickLayer> slab) {
          layers[0].insert(layers[0].end(), slab.begin(), slab.end());
        },
        context());
    const std::vector<double> exact = field.on_grid(frames);
    const std::vector<float> values(exact.begin(), exact.end());
    for (uint32_t t = 0; t < edge; ++t) {
      FrameBox box;
      box.dims = {edge, edge, edge};
      box.data = values.data() + size_t{t} * edge * edge * edge;
      fit.add_frame(0, {&box, 1});
    }
    const Lattice4 lattice = fit.finish().lattice;
    const MemorySamples samples(lattice, {0}, std::move(layers));
    const Coefficients c(samples, 0, make_kernel(GetParam().kernel), 0, large_cache);
    const Vec3 unit = lattice.lattice_unit();
    std::vector<float> got;
    for (const double t : grid[3]) {
      const Slice slice = time_slice(c, t, {0, 0}, {}, context());
      std::vector<Vec3> at;
      for (const double z : grid[2])
        for (const double y : grid[1])
          for (const double x : grid[0]) at.push_back({x / unit[0], y / unit[1], z / unit[2]});
      std::vector<float> part(at.size());
      (void)evaluate(slice, at, part, {});
      got.insert(got.end(), part.begin(), part.end());
    }
    EXPECT_GE(snr_db(got, field.on_grid(grid)), GetParam().snr[r]) << "rho " << rhos[r];
  }
}

// The error of a slice hardly depends on where between two layers its instant lies. Low frequencies are the
// worst case for splines in time: of B-splines their images about the layer frequency meet in phase between
// layers and cancel on them, which bends mend; see tests/bench/notes/kernels.md.
struct Pulsing {
  const char* kernel;
  std::array<double, 3> spread; // dB at most, at rho 0.5, 0.7, 0.9
};
std::ostream& operator<<(std::ostream& out, const Pulsing& p) { return out << p.kernel; }
class Phases : public testing::TestWithParam<Pulsing> {};
INSTANTIATE_TEST_SUITE_P(EvaluateAccuracy, Phases,
                         testing::Values(Pulsing{"default", {1, 1, 1}}, Pulsing{"fine", {1.2, 1.2, 1}},
                                         Pulsing{"gauss09", {1.2, 1, 1}}));

TEST_P(Phases, OfTheInstantChangeTheErrorLittle) {
  const auto lattice = Lattice4::fit(LatticeKind::d4star, {edge, edge, edge, edge});
  for (size_t r = 0; r < rhos.size(); ++r) {
    const PlaneWaves field(200, rhos[r], 17);
    const MemorySamples samples = on_sites(lattice, field);
    const Coefficients c(samples, 0, make_kernel(GetParam().kernel), 0, large_cache);
    double low = 1e9, high = -1e9;
    for (int phase = 0; phase < 4; ++phase) {
      auto points = random_points(lattice, 2500, 23, margin);
      for (size_t i = 0; i < points.size(); ++i) // the same phase at several instants
        points[i][3] =
            lattice.layer_frame(18 + static_cast<int32_t>(i % 5)) + phase / 4.0 * lattice.time_step;
      std::vector<double> truth;
      for (const Vec4& p : points) truth.push_back(field(p));
      const double db = snr_db(values_of(c, points), truth);
      low = std::min(low, db), high = std::max(high, db);
    }
    EXPECT_LE(high - low, GetParam().spread[r]) << "rho " << rhos[r];
  }
}

// The paper's own pipeline (approximate slice, Gaussian splats, both normalised) as stated: no better, no
// worse.
TEST(EvaluateAccuracy, PaperMode) {
  const auto lattice = Lattice4::fit(LatticeKind::d4star, {edge, edge, edge, edge});
  const auto points = random_points(lattice, 1500, 19, margin);
  constexpr std::array<double, 3> stated{13.9, 9.1, 5.8};
  for (size_t r = 0; r < rhos.size(); ++r) {
    const PlaneWaves field(120, rhos[r], 17);
    std::vector<double> truth;
    for (const Vec4& p : points) truth.push_back(field(p));
    const MemorySamples samples = on_sites(lattice, field);
    EXPECT_NEAR(snr_db(values_of({samples, 0, make_kernel("paper"), 0, large_cache}, points), truth),
                stated[r], 0.7);
  }
  // Without division a constant would be 1.037 on one coset and 0.736 on the other at the instant of a layer.
  const TemporalKernel beta = make_kernel("paper").time;
  double own = 0, other = 0;
  for (int k = -3; k <= 3; ++k)
    own += beta.value(k * std::numbers::sqrt2), other += beta.value((k + 0.5) * std::numbers::sqrt2);
  EXPECT_NEAR(own / other, 1.0366 / 0.7358, 1e-3);
}

// Marschner & Lobb on 41^3 samples of CC or 71 % of them on BCC, points in [-0.9, 0.9]^3. CC with the
// interpolating tricubic B-spline, measured by the benchmark: 35.8 dB as published, 40.0 limited to the ball
// of rho 0.9.
double marschner_lobb_psnr(const char* kernel, const MarschnerLobb& field) {
  const auto lattice = Lattice4::fit(LatticeKind::d4star, {41, 41, 41, 1});
  const auto unit_of = [](const Vec4& p) { return Vec3{p[0] / 20 - 1, p[1] / 20 - 1, p[2] / 20 - 1}; };
  const MemorySamples samples = test::sample_field(lattice, [&](const Vec4& p) { return field(unit_of(p)); });
  auto points = random_points(lattice, 5000, 3, 2);
  const std::vector<float> got = values_of({samples, 0, make_kernel(kernel), 0, large_cache}, points);
  double error = 0;
  for (size_t i = 0; i < points.size(); ++i) error += std::pow(got[i] - field(unit_of(points[i])), 2);
  return -10 * std::log10(error / static_cast<double>(points.size()));
}

TEST(EvaluateAccuracy, MarschnerLobb) {
  const MarschnerLobb published, in_ball(9);
  EXPECT_GE(marschner_lobb_psnr("default", published), 34.9);
  EXPECT_GE(marschner_lobb_psnr("fine", published), 35.7);
  EXPECT_GE(marschner_lobb_psnr("default", in_ball), 41);
  EXPECT_GE(marschner_lobb_psnr("fine", in_ball), 43);
}

} // namespace
} // namespace bccsplat
