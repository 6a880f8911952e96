// SPDX-License-Identifier: Apache-2.0
// The ends of a series: what moves there is stored and read as well as elsewhere.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "field/coefficients/coefficients.h"
#include "field/evaluate.h"
#include "field/sample_grid.h"
#include "fit/beyond/end_layers.h"
#include "fit/beyond/ends.h"
#include "slice/axis_slice.h"
#include "slice/time_slice.h"
#include "tests/support/band_limited.h"
#include "tests/support/fields.h"
#include "tests/support/larger.h"
#include "tests/unit/fit/fit_series.h"

namespace bccsplat::test {
namespace {

constexpr uint64_t cache = 1ull << 30;
constexpr int32_t lead = 2;

// A blob that moves by 0.6 samples a frame, far from the borders.
double blob(double x, double y, double z, double t) {
  const double dx = x - 8 - 0.6 * t, dy = y - 12 - 0.125 * t, dz = z - 11;
  return std::exp(-(dx * dx + dy * dy + dz * dz) / (2 * 2.2 * 2.2));
}

MemorySamples samples_of(const Fitted& f) { return {f.report.lattice, {0}, {f.layers}}; }

Fitted fitted(const Series& s, int32_t layers, bool length_known = true) {
  FitOptions o = options_for(s);
  o.lead = layers;
  if (!length_known) o.dims[3] = 0;
  return run_fit(o, s);
}

// Largest error at random points of the stretches [t, t + 1) for t = 0, 0.5, 1, .. of the series.
std::vector<double> worst_by_stretch(const Fitted& f, const Series& s) {
  TestContext context;
  const MemorySamples samples = samples_of(f);
  const Coefficients c(samples, 0, make_kernel("default"), 0, cache);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> part(0, 1);
  std::vector<double> worst;
  for (double t = 0; t + 1 <= s.dims[3] - 1.0; t += 0.5) {
    std::vector<Vec4> points;
    for (int i = 0; i < 3000; ++i) {
      const double at = t + (i % 10 == 0 ? 0 : part(random)), radius = 5 * std::cbrt(part(random));
      // Near the blob, where the errors are.
      Vec3 d{part(random) - 0.5, part(random) - 0.5, part(random) - 0.5};
      d = (radius / std::max(length(d), 1e-6)) * d;
      points.push_back({8 + 0.6 * at + d[0], 12 + 0.125 * at + d[1], 11 + d[2], at});
    }
    std::vector<float> values(points.size());
    const EvaluateMisses misses = evaluate4(c, points, values, {}, context.get());
    EXPECT_EQ(misses.outside, 0u);
    double most = 0;
    for (size_t i = 0; i < points.size(); ++i) {
      const Vec4& p = points[i];
      most = larger(most, std::fabs(values[i] - blob(p[0], p[1], p[2], p[3])));
    }
    worst.push_back(most);
  }
  return worst;
}

Series blob_series() { return Series({30, 24, 23, 22}, blob); }

TEST(FitEnds, PredictionsKeepConstantsAndFollowWhatIsSlow) {
  for (const double widening : {1.0, 1.6, 3.0}) {
    EndFrames ends(widening, 3e-5);
    for (const int64_t frames : {2, 5, 8, 100})
      for (const int64_t distance : {1, 2, 5, 9}) {
        const std::vector<double>& w = ends.weights(distance, frames);
        EXPECT_EQ(w.size(), static_cast<size_t>(std::min(frames, ends.used())));
        EXPECT_NEAR(std::accumulate(w.begin(), w.end(), 0.0), 1, 1e-9);
        double squares = 0; // what becomes of white noise
        for (const double v : w) squares += v * v;
        EXPECT_LT(squares, widening == 1 ? 130 : 600);
      }
    // A wave of 0.3 of the Nyquist frequency, one frame on (of the lattice): most of it is predicted.
    const std::vector<double>& w = ends.weights(1, 100);
    double worst = 0;
    for (int k = 0; k < 24; ++k) {
      const double phase = k * std::numbers::pi / 12,
                   step = 0.3 / std::sqrt(6.0) * std::numbers::pi / widening;
      double sum = 0;
      for (size_t i = 0; i < w.size(); ++i) sum += w[i] * std::cos(phase + step * static_cast<double>(i));
      worst = larger(worst, std::fabs(sum - std::cos(phase - step)));
    }
    EXPECT_LT(worst, 0.1 / widening + 0.05) << widening;
  }
}

TEST(FitEnds, AMovingBlobIsAsGoodInTheFirstAndLastFrames) {
  const Series s = blob_series();
  const auto ratio = [&](int32_t layers) {
    const std::vector<double> worst = worst_by_stretch(fitted(s, layers), s);
    const size_t n = worst.size();
    const double inside = *std::max_element(worst.begin() + 14, worst.end() - 14);
    const double at_ends = std::max(*std::max_element(worst.begin(), worst.begin() + 8),
                                    *std::max_element(worst.end() - 8, worst.end()));
    EXPECT_GT(n, 36u);
    return at_ends / inside;
  };
  EXPECT_LT(ratio(lead), 2);
  EXPECT_GT(ratio(0), 5); // mirrored: what is avoided
}

// SNR in dB of waves in `frames` frames, at times from either end, in the middle of space.
double wave_snr(double rho, uint32_t frames, int32_t layers, const std::vector<double>& times,
                LatticeKind kind = LatticeKind::d4star) {
  TestContext context;
  const PlaneWaves field(30, rho, 11);
  const Series s({22, 22, 22, frames}, [&](double x, double y, double z, double t) {
    return field({x, y, z, t});
  });
  FitOptions o = options_for(s);
  o.lead = layers, o.lattice = kind;
  const Fitted f = run_fit(o, s);
  const MemorySamples samples = samples_of(f);
  const Coefficients c(samples, 0, make_kernel("default"), 0, cache);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> middle(9, 12);
  std::vector<Vec4> points;
  for (size_t i = 0; i < 1200; ++i) {
    const double off = times[i / 2 % times.size()];
    points.push_back({middle(random), middle(random), middle(random), i % 2 ? frames - 1.0 - off : off});
  }
  std::vector<float> values(points.size());
  (void)evaluate4(c, points, values, {}, context.get());
  double signal = 0, error = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    const double truth = field(points[i]), e = values[i] - truth;
    signal += truth * truth, error += e * e;
  }
  return 10 * std::log10(signal / error);
}

TEST(FitEnds, WavesOfTheBandAreAsGoodToAFewDecibels) {
  const std::vector<double> ends{0, 0.5}, inside{11, 11.25, 11.5, 11.75, 12};
  EXPECT_GT(wave_snr(0.3, 24, lead, ends), 44);
  EXPECT_GT(wave_snr(0.5, 24, lead, ends), 38);
  EXPECT_GT(wave_snr(0.7, 24, lead, ends), 28);
  EXPECT_LT(wave_snr(0.5, 24, 0, ends), 24);
  // Nothing happens inside.
  EXPECT_NEAR(wave_snr(0.5, 24, lead, inside), wave_snr(0.5, 24, 0, inside), 1);
}

// Bounds at the first frame and half a frame on; without the factors against mirrors, or with less bold
// predictions, they are missed.
TEST(FitEnds, WavesOfShortSeriesAreAsGood) {
  const double bounds[][3] = {{0.3, 50, 51}, {0.5, 41, 34.5}, {0.7, 33.5, 28}};
  for (const uint32_t frames : {6u, 10u})
    for (const auto& [rho, first, half] : bounds) {
      SCOPED_TRACE(testing::Message() << frames << " frames, rho " << rho);
      EXPECT_GT(wave_snr(rho, frames, lead, {0}), first);
      EXPECT_GT(wave_snr(rho, frames, lead, {0.5}), half);
    }
  // On Cartesian layers half a frame off.
  EXPECT_GT(wave_snr(0.5, 10, lead, {0.5}, LatticeKind::cc), 32.5);
}

TEST(FitEnds, ConstantsStayConstant) {
  TestContext context;
  const Series s({9, 8, 7, 6}, [](double, double, double, double) { return 3.25; });
  const Fitted f = fitted(s, lead);
  for (int32_t m = 0; m < f.report.lattice.layers(); ++m)
    for (const float v : f.dense(m)) ASSERT_EQ(v, 3.25f);
  const MemorySamples samples = samples_of(f);
  const Coefficients c(samples, 0, make_kernel("default"), 0, cache);
  for (const double t : {0.0, 0.3, 4.9, 5.0}) {
    const Slice slice = time_slice(c, t, {0, 0}, {}, context.get());
    EXPECT_NEAR(evaluate_reference(slice, {1, 2, 1.5}, nullptr), 3.25, 3.25 * 0.0025);
  }
}

TEST(FitEnds, TheLayersAroundTheSeriesChangeNothingInIt) {
  const Series s = noise({12, 11, 10, 20}, 4);
  const Fitted with = fitted(s, lead), without = fitted(s, 0);
  const Lattice4 &a = with.report.lattice, &b = without.report.lattice;
  EXPECT_EQ(a.last_layer, b.last_layer + 2 * lead);
  EXPECT_EQ(a.layer_frame(lead), 0);
  for (int32_t m = 0; m < b.layers(); ++m) {
    ASSERT_EQ(a.layer_frame(m + lead), b.layer_frame(m));
    if (b.layer_frame(m) < 4 || b.layer_frame(m) > 15) continue; // no frame beyond an end is in reach
    ASSERT_EQ(with.dense(m + lead), without.dense(m)) << m;
  }
}

TEST(FitEnds, DoNotDependOnWhatIsKnownInAdvanceOrOnThreads) {
  for (const uint32_t frames : {2u, 3u, 5u, 9u, 17u}) {
    const Series s = noise({14, 9, 11, frames}, frames);
    const Fitted known = fitted(s, lead);
    EXPECT_TRUE(identical(known, fitted(s, lead, false))) << frames;
    FitOptions o = options_for(s);
    o.lead = lead;
    EXPECT_TRUE(identical(known, run_fit(o, s, 3))) << frames;
  }
  const Series still = noise({9, 9, 9, 1}, 1);
  EXPECT_TRUE(fitted(still, lead, false).report.lattice.is_static());
  FitOptions odd = options_for(still);
  odd.lead = 3;
  EXPECT_THROW(run_fit(odd, still), Error);
}

double mean_square(const std::vector<float>& values) {
  double sum = 0;
  for (const float v : values) sum += static_cast<double>(v) * v;
  return sum / static_cast<double>(values.size());
}

// What is predicted well is continued boldly, what is not with care, each end by its own frames.
TEST(FitEnds, PredictionsAreAsBoldAsTheSeries) {
  Series s = noise({20, 20, 20, 24}, 5);
  const PlaneWaves waves(30, 0.4, 3);
  // Waves first, frames that have nothing to do with each other from the middle on.
  for (size_t t = 0; t < 12; ++t)
    for (size_t i = 0; i < s.frame_samples(); ++i)
      s.values[t * s.frame_samples() + i] =
          static_cast<float>(waves({static_cast<double>(i % 20), static_cast<double>(i / 20 % 20),
                                    static_cast<double>(i / 400), 1.0 * static_cast<double>(t)}));
  const Fitted f = fitted(s, lead);
  const Lattice4& l = f.report.lattice;
  const double inside = mean_square(f.dense(l.last_layer - 8));
  EXPECT_LT(mean_square(f.dense(l.last_layer - 1)), inside);
  EXPECT_LT(mean_square(f.dense(l.last_layer)), 2 * inside);
  // Layer 1, a layer before the first frame, which holds nothing against mirrors: the waves themselves.
  double error = 0, power = 0;
  const Int3 n = l.space.dims(1);
  const std::vector<float> got = f.dense(1);
  for (int32_t z = 3; z < n[2] - 3; ++z)
    for (int32_t y = 3; y < n[1] - 3; ++y)
      for (int32_t x = 3; x < n[0] - 3; ++x) {
        const Vec3 p = l.site_position(1, {x, y, z});
        const double truth = waves({p[0], p[1], p[2], l.layer_frame(1)});
        const double e = got[(z * n[1] + y) * n[0] + x] - truth;
        error += e * e, power += truth * truth;
      }
  EXPECT_GT(10 * std::log10(power / error), 17);
}

TEST(LayerTable, TheOutermostOfTwoLayersMakesUpForMirrors) {
  for (const LatticeKind kind : {LatticeKind::d4star, LatticeKind::cc}) {
    const Lattice4 lattice = Lattice4::fit(kind, {9, 9, 9, 12}, {1, 1, 1, 1}, lead);
    const auto wave = [](double t) { return std::cos(.3 * t + .5); };
    for (int32_t m = 0; m < lattice.layers(); ++m) {
      const FilterTable table = layer_table(lattice, m, true, 1);
      double sum = 0, weights = 0;
      for (int k = 0; k < table.taps; ++k) {
        const double w = table.weight[k];
        weights += w, sum += w * wave(static_cast<double>(table.first[0] + k));
      }
      EXPECT_NEAR(weights, 1, 1e-5);
      double want = wave(lattice.layer_frame(m));
      if (kind == LatticeKind::d4star && (m == 0 || m == lattice.last_layer)) {
        const auto outside = [&](int32_t k) {
          return wave(lattice.layer_frame(m == 0 ? lead - k : lattice.last_layer - lead + k));
        };
        want += .25 * (outside(0) - outside(1) + outside(3) - outside(4));
      }
      EXPECT_NEAR(sum, want, .003) << m;
    }
  }
}

TEST(FitEnds, AFrameMissingAtTheStartIsThatWhichFollows) {
  Series s = noise({10, 9, 8, 14}, 6);
  std::fill_n(s.values.begin(), 3 * s.frame_samples(), std::numeric_limits<float>::quiet_NaN());
  Series filled = s;
  for (size_t t = 0; t < 3; ++t)
    std::copy_n(s.frame(3).begin(), s.frame_samples(), filled.values.begin() + (t * s.frame_samples()));
  FitOptions o = options_for(s);
  o.lead = lead;
  o.nonfinite = NonFinite::hole;
  const Fitted a = run_fit(o, s), b = run_fit(o, filled);
  for (int32_t m = 0; m < a.report.lattice.layers(); ++m) ASSERT_EQ(a.dense(m), b.dense(m)) << m;
}

// Axis slices turn time into an axis of space: the layers before frame 0 must not shift it.
TEST(FitEnds, AxisSlicesKeepTheirTimes) {
  TestContext context;
  const Series s = blob_series();
  const Fitted f = fitted(s, lead);
  const MemorySamples samples = samples_of(f);
  const Coefficients c(samples, 0, make_kernel("default"), 0, cache);
  for (size_t axis = 0; axis < 3; ++axis) {
    const double position = 11.3;
    const Slice slice = axis_slice(c, axis, position, {}, context.get());
    std::vector<size_t> rest;
    for (size_t a = 0; a < 3; ++a)
      if (a != axis) rest.push_back(a);
    std::vector<Vec3> at;
    std::vector<Vec4> points;
    for (int i = 0; i < 900; ++i) {
      Vec4 p{};
      p[axis] = position;
      p[rest[0]] = 8 + 0.37 * (i % 20), p[rest[1]] = 8 + 0.31 * (i / 20 % 20), p[3] = 21.0 * (i % 31) / 30;
      points.push_back(p);
      at.push_back({p[rest[0]], p[rest[1]], p[3]}); // slice space: u, v, w
    }
    std::vector<float> cut(at.size()), direct(at.size());
    EXPECT_EQ(sample_points(slice, at, cut, {}, context.get()).outside, 0u);
    (void)evaluate4(c, points, direct, {}, context.get());
    for (size_t i = 0; i < at.size(); ++i) ASSERT_NEAR(cut[i], direct[i], 0.02f) << axis << " " << at[i][2];
    // No further than the first and the last frame.
    std::vector<float> none(2);
    const std::vector<Vec3> beyond{{10, 10, -0.1}, {10, 10, 21.1}};
    EXPECT_EQ(sample_points(slice, beyond, none, {}, context.get()).outside, 2u);
    Grid grid;
    grid.origin = {10, 10, -1}, grid.dims = {1, 1, 25};
    std::vector<float> line(25);
    sample_grid(slice, grid, line.data(), context.get());
    for (size_t i = 0; i < line.size(); ++i) EXPECT_EQ(std::isnan(line[i]), i < 1 || i > 22) << i;
  }
}

TEST(FitEnds, ValuesThatWouldOverflowAreRefused) {
  for (const double large : {2e36, -3e38}) {
    const Series s({6, 5, 4, 5},
                   [&](double x, double, double, double t) { return x == 3 && t == 2 ? large : 1; });
    try {
      (void)run_fit(options_for(s), s);
      ADD_FAILURE() << large << " was taken";
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), Code::limit_exceeded);
      EXPECT_NE(e.message().find("frame 2"), std::string::npos) << e.message();
    }
  }
  // The largest that are taken come back: nothing overflows on the way, whatever surrounds them.
  TestContext context;
  const Series s({9, 9, 9, 9}, [](double x, double y, double z, double t) {
    return std::fmod(x + y + z + t, 2) == 0 ? 1e36 : -1e36;
  });
  for (const char* kernel : {"default", "fine"}) {
    const Fitted f = fitted(s, lead);
    const MemorySamples samples = samples_of(f);
    const Coefficients c(samples, 0, make_kernel(kernel), 0, cache);
    std::vector<Vec4> points = random_points(f.report.lattice, 500, 2);
    std::vector<float> values(points.size());
    (void)evaluate4(c, points, values, {}, context.get());
    for (const float v : values) ASSERT_TRUE(std::isfinite(v)) << kernel;
  }
}

} // namespace
} // namespace bccsplat::test
