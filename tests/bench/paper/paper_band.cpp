// SPDX-License-Identifier: Apache-2.0
// The paper's section 3 takes data for limited to a ball of frequencies. What D4* holds is a 24-cell around
// that ball: what its corners are worth, by plane waves of them, and what real series have in them.
#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <numbers>
#include <random>

#include "field/coefficients/coefficients.h"
#include "field/evaluate.h"
#include "tests/bench/paper/paper.h"
#include "tests/support/fields.h"

namespace bccsplat::bench {
namespace {

using test::TestContext;

// Frequencies in cycles per T: Nyquist of CC is 1/2.
double length4(const Vec4& f) { return std::sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2] + f[3] * f[3]); }

// Returns whether a frequency is nearer to 0 than to any other point of the dual of D4*: |f_i| + |f_j| <
// 1/sqrt2 for all pairs.
bool in_24_cell(const Vec4& f) {
  std::array<double, 4> size;
  for (size_t a = 0; a < 4; ++a) size[a] = std::fabs(f[a]);
  std::sort(size.begin(), size.end());
  return size[2] + size[3] < 1 / std::numbers::sqrt2;
}

struct Region {
  const char* name;
  bool (*holds)(const Vec4&);
};
constexpr double nyquist = 0.5, corner_half = 0.6;
constexpr Region regions[] = {
    {"ball, up to 0.9 of its radius", [](const Vec4& f) { return length4(f) < 0.9 * nyquist; }},
    {"ball, 0.9 to 1", [](const Vec4& f) { return length4(f) >= 0.9 * nyquist && length4(f) < nyquist; }},
    {"corners of the 24-cell, 1 to 1.2",
     [](const Vec4& f) { return in_24_cell(f) && length4(f) >= nyquist && length4(f) < corner_half; }},
    {"corners, 1.2 to 1.41", [](const Vec4& f) { return in_24_cell(f) && length4(f) >= corner_half; }},
    {"beyond, in the cube of CC", [](const Vec4& f) { return !in_24_cell(f); }}};

Vec4 in_cube(std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-nyquist, nyquist);
  return {uniform(random), uniform(random), uniform(random), uniform(random)};
}

// A sum of waves of a region, mean square 1.
class RegionWaves {
 public:
  RegionWaves(const Region& region, size_t count) {
    std::mt19937 random(5);
    while (waves_.size() < count)
      if (const Vec4 f = in_cube(random); region.holds(f)) waves_.push_back(f);
  }
  [[nodiscard]] double operator()(const Vec4& p) const {
    double sum = 0;
    for (size_t n = 0; n < waves_.size(); ++n)
      sum += std::cos(2 * std::numbers::pi * dot4(waves_[n], p) + static_cast<double>(n));
    return sum * std::sqrt(2 / static_cast<double>(waves_.size()));
  }

 private:
  static double dot4(const Vec4& a, const Vec4& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
  }
  std::vector<Vec4> waves_;
};

double snr_of(const RegionWaves& waves, LatticeKind kind, const char* kernel, uint32_t edge,
              const Context& context) {
  const Lattice4 lattice = Lattice4::fit(kind, {edge, edge, edge, edge});
  const MemorySamples samples = test::sample_field(lattice, waves);
  const Coefficients coefficients(samples, 0, make_kernel(kernel), 0, test::large_cache);
  const auto points = test::random_points(lattice, 2000, 7, edge / 2.0 - 3);
  std::vector<float> values(points.size());
  (void)evaluate4(coefficients, points, values, {}, context);
  double signal = 0, error = 0;
  for (size_t n = 0; n < points.size(); ++n) {
    const double truth = waves(points[n]);
    signal += truth * truth, error += std::pow(values[n] - truth, 2);
  }
  return 10 * std::log10(signal / error);
}

using Complex = std::complex<double>;

// The Fourier transform of a power of two of values, `stride` apart, in place.
void transform(Complex* line, size_t count, size_t stride) {
  std::vector<Complex> v(count);
  for (size_t i = 0, j = 0; i < count; ++i) {
    v[j] = line[i * stride];
    for (size_t bit = count / 2; bit > 0 && ((j ^= bit) & bit) == 0; bit /= 2) {
    }
  }
  for (size_t half = 1; half < count; half *= 2)
    for (size_t i = 0; i < count; i += 2 * half)
      for (size_t k = 0; k < half; ++k) {
        const Complex w =
            std::polar(1.0, -std::numbers::pi * static_cast<double>(k) / static_cast<double>(half));
        const Complex a = v[i + k], b = w * v[i + k + half];
        v[i + k] = a + b, v[i + k + half] = a - b;
      }
  for (size_t i = 0; i < count; ++i) line[i * stride] = v[i];
}

// Returns the part of the variance that a series has in each region: of its middle, as large as powers of two
// are, under a window that ends at 0.
std::array<double, std::size(regions)> energy_of(const FitSource& source) {
  std::array<size_t, 4> n, first;
  size_t count = 1;
  for (size_t a = 0; a < 4; ++a) {
    for (n[a] = 1; 2 * n[a] <= source.dims[a]; n[a] *= 2) {
    }
    first[a] = (source.dims[a] - n[a]) / 2, count *= n[a];
  }
  std::vector<Complex> values;
  values.reserve(count);
  const auto window = [&](size_t a, size_t i) {
    return n[a] > 1 ? std::pow(std::sin(std::numbers::pi * (static_cast<double>(i) + 0.5) /
                                        static_cast<double>(n[a])),
                               2)
                    : 1;
  };
  for (size_t t = 0; t < n[3]; ++t) {
    const std::vector<float> frame = source.frame(static_cast<uint32_t>(first[3] + t));
    for (size_t z = 0; z < n[2]; ++z)
      for (size_t y = 0; y < n[1]; ++y)
        for (size_t x = 0; x < n[0]; ++x)
          values.emplace_back(
              frame[((first[2] + z) * source.dims[1] + first[1] + y) * source.dims[0] + first[0] + x] *
              window(0, x) * window(1, y) * window(2, z) * window(3, t));
  }
  size_t stride = 1;
  for (size_t a = 0; a < 4; ++a) {
    for (size_t i = 0; i < count; ++i)
      if (i / stride % n[a] == 0) transform(values.data() + i, n[a], stride);
    stride *= n[a];
  }
  std::array<double, std::size(regions)> part{};
  double all = 0;
  for (size_t i = 0; i < count; ++i) {
    Vec4 f;
    bool mean = true; // the mean and what the window spreads of it
    size_t rest = i;
    for (size_t a = 0; a < 4; ++a) {
      const size_t k = rest % n[a];
      rest /= n[a];
      const size_t low = std::min(k, n[a] - k);
      f[a] = static_cast<double>(low) / static_cast<double>(n[a]);
      mean = mean && low <= 1;
    }
    if (mean) continue;
    const double energy = std::norm(values[i]);
    all += energy;
    for (size_t r = 0; r < part.size(); ++r)
      if (regions[r].holds(f)) part[r] += energy;
  }
  for (double& p : part) p /= all;
  return part;
}

} // namespace

void report_band(const Report& report) {
  TestContext context(1);
  const uint32_t edge = report.quick ? 18 : 30;
  std::mt19937 random(1);
  std::array<size_t, std::size(regions)> inside{};
  constexpr size_t tries = 1 << 20;
  for (size_t i = 0; i < tries; ++i) {
    const Vec4 f = in_cube(random);
    for (size_t r = 0; r < inside.size(); ++r) inside[r] += regions[r].holds(f) ? 1 : 0;
  }
  std::vector<Row> rows;
  for (size_t r = 0; r < inside.size(); ++r) {
    const RegionWaves waves(regions[r], report.quick ? 10 : 40);
    rows.push_back(
        {word("frequencies", regions[r].name),
         figure("% of the cube", 100 * static_cast<double>(inside[r]) / tries, 1),
         figure("D4*, default, dB", snr_of(waves, LatticeKind::d4star, "default", edge, context.get()), 1),
         figure("D4*, fine, dB", snr_of(waves, LatticeKind::d4star, "fine", edge, context.get()), 1),
         figure("CC, twice the samples, dB", snr_of(waves, LatticeKind::cc, "default", edge, context.get()),
                1)});
  }
  report.table("The ball, the 24-cell and the cube: plane waves of each", rows);
}

void report_energy(const Report& report, const std::vector<FitSource>& series) {
  std::vector<Row> rows;
  for (const FitSource& source : series) {
    const auto part = energy_of(source);
    Row row{word("series", source.name)};
    for (size_t r = 0; r < part.size(); ++r)
      row.push_back(figure(concat(regions[r].name, ", %"), 100 * part[r], 4));
    rows.push_back(row);
  }
  report.table("Variance of series by frequency, without the mean", rows);
}

} // namespace bccsplat::bench
