// SPDX-License-Identifier: Apache-2.0
// Gradients are the derivatives of the values that come with them, corrections included.
#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "support.h"

using namespace host;

namespace {

constexpr double h = 0.01;
constexpr size_t count = 300;

// Finer than the lattice holds, so that a bound needs many corrections.
double rough(double x, double y, double z, double t) {
  return blob(x, y, z, t) + 5 * std::sin(1.9 * x + 2.3 * y + 0.7 * z + t);
}

Volume series(const Device& device, const std::string& path, const char* kernel, double bound) {
  const Series s{.field = rough};
  auto options = options_of(s);
  options.abs_error = bound, options.recommended_kernel = kernel;
  auto report = sized<bccsplat_writer_report>();
  {
    const Writer w = make_writer(device, path, options);
    EXPECT_OK(add_frames(w.get(), s));
    EXPECT_OK(bccsplat_writer_finish(w.get(), &report));
  }
  EXPECT_EQ(report.corrected > 1000, bound > 0) << report.corrected;
  return open(device, path);
}

// Compares the gradients of a field of `Axes` coordinates with differences of its values.
// evaluate(points, values, gradients or null): as the calls of the API.
template<size_t Axes, class Evaluate> void expect_derivatives(const Evaluate& evaluate, bool whole) {
  std::mt19937 random(5);
  const std::array<double, 4> last{17, 16, 15, 5};
  std::vector<double> points;
  for (size_t n = 0; n < count; ++n)
    for (size_t a = 0; a < Axes; ++a) {
      const double p = std::uniform_real_distribution<double>(1, last[a])(random);
      points.push_back(whole ? std::floor(p) : p);
    }
  std::vector<float> values(count), gradients(count * Axes), low(count), high(count);
  EXPECT_OK(evaluate(points.data(), values.data(), gradients.data()));
  double most = 0, off = 0;
  for (size_t a = 0; a < Axes; ++a) {
    std::vector<double> moved = points;
    for (size_t n = 0; n < count; ++n) moved[n * Axes + a] -= h;
    EXPECT_OK(evaluate(moved.data(), low.data(), nullptr));
    for (size_t n = 0; n < count; ++n) moved[n * Axes + a] += 2 * h;
    EXPECT_OK(evaluate(moved.data(), high.data(), nullptr));
    for (size_t n = 0; n < count; ++n) {
      const double difference = (static_cast<double>(high[n]) - static_cast<double>(low[n])) / (2 * h);
      most = larger(most, std::fabs(difference));
      off = larger(off, std::fabs(difference - static_cast<double>(gradients[n * Axes + a])));
    }
  }
  EXPECT_GT(most, 15);
  EXPECT_LT(off, 0.005 * most);
}

TEST(Gradients, AreTheDerivativesOfTheValues) {
  const Folder folder;
  const Device device = make_device();
  for (const char* kernel : {"default", "fine"})
    for (const double bound : {0.0, 0.05}) {
      const Volume volume = series(device, folder.free_file("g.bcc4"), kernel, bound);
      const Slice slice = cut_time(volume, 3.3);
      for (const bool whole : {false, true}) {
        SCOPED_TRACE(std::string(kernel) + (bound > 0 ? ", corrected" : "") + (whole ? ", at samples" : ""));
        expect_derivatives<4>(
            [&](const double* at, float* values, float* gradients) {
              return bccsplat_volume_evaluate(volume.get(), count, at, values, gradients);
            },
            whole);
        expect_derivatives<3>(
            [&](const double* at, float* values, float* gradients) {
              return bccsplat_slice_evaluate(slice.get(), count, at, values, gradients);
            },
            whole);
      }
    }
}

} // namespace
