// What becomes of a constant, and of what varies little around a large one.
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>

#include "field/coefficients/coefficients.h"
#include "field/evaluate.h"
#include "fit/fit.h"
#include "kernel/wave_error.h"
#include "tests/bench/fit/fit_source.h"
#include "tests/bench/kernels/kernels_chain.h"
#include "tests/support/fields.h"

namespace bccsplat::bench {
namespace {

using Complex = std::complex<double>;
constexpr const char* kernels[] = {"fast", "radial18+b3", "default", "fine"};
constexpr double plane = 1 / std::numbers::sqrt2; // T

struct Sum {
  Complex value;
  std::array<Complex, 3> gradient; // in space, per T

  // Divided by the sum for coefficients that are all 1.
  [[nodiscard]] Sum over(const Sum& ones) const {
    Sum r{value / ones.value, gradient};
    for (size_t a = 0; a < 3; ++a) r.gradient[a] = (gradient[a] - r.value * ones.gradient[a]) / ones.value;
    return r;
  }
};

// The field at p (T) of coefficients that are a function of the place of their site, on D4* without ends.
template<class F> Sum field_at(const Kernel& kernel, const Vec4& p, const F& coefficient) {
  std::array<int, 4> low{}, high{};
  for (size_t a = 0; a < 4; ++a) {
    const double reach = a < 3 ? kernel.space.radius : kernel.time.half_width;
    low[a] = static_cast<int>(std::ceil((p[a] - reach) / plane));
    high[a] = static_cast<int>(std::floor((p[a] + reach) / plane));
  }
  Sum sum{};
  std::array<int, 4> h{};
  const auto first = [&](size_t a) { return low[a] + ((low[a] ^ h[3]) & 1); };
  for (h[3] = low[3]; h[3] <= high[3]; ++h[3]) {
    const double beta = kernel.time.value(h[3] * plane - p[3]);
    for (h[2] = first(2); h[2] <= high[2]; h[2] += 2)
      for (h[1] = first(1); h[1] <= high[1]; h[1] += 2)
        for (h[0] = first(0); h[0] <= high[0]; h[0] += 2) {
          const Vec3 d{p[0] - h[0] * plane, p[1] - h[1] * plane, p[2] - h[2] * plane};
          const Complex c = beta * coefficient(Vec4{h[0] * plane, h[1] * plane, h[2] * plane, h[3] * plane});
          sum.value += c * kernel.space.value(dot(d, d));
          for (size_t a = 0; a < 3; ++a) sum.gradient[a] += c * (2 * d[a] * kernel.space.slope(dot(d, d)));
        }
  }
  return sum;
}

Sum ones_at(const Kernel& kernel, const Vec4& p) {
  return field_at(kernel, p, [](const Vec4&) { return Complex(1); });
}

std::vector<Vec4> points_of_a_cell(size_t count) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0, std::numbers::sqrt2);
  std::vector<Vec4> points(count);
  for (Vec4& p : points)
    for (double& x : p) x = unit(random);
  return points;
}

// Of the field of a constant 1, and of the ramp x, whose coefficients are its samples.
Row ripple_row(const std::string& name, size_t count) {
  const Kernel kernel = make_kernel(name);
  double largest = 0, square = 0, steep = 0;
  std::array<double, 2> ramp{}, ramp_largest{}; // gradients, plain and divided
  for (const Vec4& p : points_of_a_cell(count)) {
    const Sum ones = ones_at(kernel, p);
    const double e = ones.value.real() - 1;
    largest = std::max(largest, std::fabs(e)), square += e * e;
    const Sum x = field_at(kernel, p, [](const Vec4& site) { return Complex(site[0]); });
    for (const bool divided : {false, true}) {
      const Sum s = divided ? x.over(ones) : x;
      double off = 0;
      for (size_t a = 0; a < 3; ++a) {
        off += std::norm(s.gradient[a] - (a == 0 ? 1.0 : 0.0));
        if (!divided) steep += std::norm(ones.gradient[a]);
      }
      ramp[divided] += off, ramp_largest[divided] = std::max(ramp_largest[divided], std::sqrt(off));
    }
  }
  const auto n = static_cast<double>(count);
  return {word("kernel", name),
          figure("constant: largest error %", 100 * largest, 3),
          figure("RMS %", 100 * std::sqrt(square / n), 3),
          figure("gradient RMS % per T", 100 * std::sqrt(steep / n), 2),
          figure("ramp: gradient RMS %", 100 * std::sqrt(ramp[0] / n), 2),
          figure("largest %", 100 * ramp_largest[0], 2),
          figure("divided: RMS %", 100 * std::sqrt(ramp[1] / n), 2),
          figure("largest %", 100 * ramp_largest[1], 2)};
}

// SNR of waves through the shipped prefilter, of values and gradients in space: as shipped / divided.
std::array<Row, 2> wave_rows(const std::string& name, size_t count) {
  const Kernel kernel = make_kernel(name);
  std::array<Row, 2> rows;
  for (Row& row : rows) row = {word("kernel", name)};
  const std::vector<Vec4> points = points_of_a_cell(12);
  for (const double rho : {0.1, 0.2, 0.3, 0.5, 0.7}) {
    std::array<double, 2> error{}, steep_error{};
    double power = 0, steep = 0;
    for (const auto& xi : ball_frequencies(4, rho, count)) {
      const double q = prefilter_symbol(kernel.prefilter4, neighbour_means4(xi), 16);
      const auto wave = [&](const Vec4& p) {
        return std::polar(1.0,
                          2 * std::numbers::pi * (xi[0] * p[0] + xi[1] * p[1] + xi[2] * p[2] + xi[3] * p[3]));
      };
      for (const Vec4& p : points) {
        const Sum plain = field_at(kernel, p, [&](const Vec4& site) { return q * wave(site); });
        const Complex truth = wave(p);
        power += 1;
        for (size_t a = 0; a < 3; ++a) steep += std::norm(2 * std::numbers::pi * xi[a]);
        for (const bool divided : {false, true}) {
          const Sum s = divided ? plain.over(ones_at(kernel, p)) : plain;
          error[divided] += std::norm(s.value - truth);
          for (size_t a = 0; a < 3; ++a)
            steep_error[divided] +=
                std::norm(s.gradient[a] - Complex(0, 2 * std::numbers::pi * xi[a]) * truth);
        }
      }
    }
    const auto db = [](double signal, double e) { return number(10 * std::log10(signal / e), 1); };
    rows[0].push_back(word("rho " + number(rho, 1), db(power, error[0]) + " / " + db(power, error[1])));
    rows[1].push_back(
        word("rho " + number(rho, 1), db(steep, steep_error[0]) + " / " + db(steep, steep_error[1])));
  }
  return rows;
}

// A host's pressure: 101325 Pa with a signal of 50 Pa, floats, through the fit.
Row pressure_row(const std::string& what, double air, bool divided, uint32_t edge) {
  test::TestContext context;
  constexpr double base = 101325, signal = 50;
  const test::PlaneWaves waves(60, 0.3, 5);
  FitSeries s{{edge, edge, edge, edge}, {}};
  for (uint32_t t = 0; t < edge; ++t)
    for (uint32_t z = 0; z < edge; ++z)
      for (uint32_t y = 0; y < edge; ++y)
        for (uint32_t x = 0; x < edge; ++x)
          s.values.push_back(static_cast<float>(base + signal * waves({1.0 * x, 1.0 * y, 1.0 * z, 1.0 * t})));
  FitOptions options;
  options.dims = s.dims;
  options.channels[0].quantiser = quantiser_of_source(SourceType::f32, static_cast<float>(air));
  std::vector<std::vector<BrickLayer>> layers(1);
  Fit fit(
      options,
      [&](int32_t, int, std::span<const BrickLayer> slab) {
        layers[0].insert(layers[0].end(), slab.begin(), slab.end());
      },
      context.get());
  const FitSource source = source_of<float>(s, SourceType::f32, 1, what);
  for (uint32_t t = 0; t < edge; ++t) {
    const FrameBox box = source.box(t);
    fit.add_frame(0, {&box, 1});
  }
  const Lattice4 lattice = fit.finish().lattice;
  const MemorySamples samples(lattice, {static_cast<float>(air)}, std::move(layers));
  const Kernel kernel = make_kernel("default");
  const Coefficients c(samples, 0, kernel, 0, 4ull << 30);
  const std::vector<Vec4> points = test::random_points(lattice, 2000, 5, 10);
  std::vector<float> values(points.size());
  std::vector<std::array<float, 4>> gradients(points.size());
  (void)evaluate4(c, points, values, gradients, context.get());
  double error = 0, steep_error = 0, steep = 0;
  const Vec3 unit = lattice.lattice_unit();
  for (size_t i = 0; i < points.size(); ++i) {
    Sum got{static_cast<double>(values[i]) - air, {}};
    for (size_t a = 0; a < 3; ++a) got.gradient[a] = static_cast<double>(gradients[i][a]) * unit[a];
    if (divided) {
      const Vec4& p = points[i];
      got = got.over(ones_at(kernel, {p[0] / unit[0], p[1] / unit[1], p[2] / unit[2], p[3]}));
    }
    const Vec4 g = waves.gradient(points[i]);
    error += std::norm(got.value + air - base - signal * waves(points[i]));
    for (size_t a = 0; a < 3; ++a) {
      steep += std::pow(signal * g[a], 2);
      steep_error += std::norm(got.gradient[a] / unit[a] - signal * g[a]);
    }
  }
  return {word("field", what),
          figure("RMS error Pa", std::sqrt(error / static_cast<double>(points.size())), 3),
          figure("gradient, SNR dB", 10 * std::log10(steep / steep_error), 1)};
}

} // namespace

void run_kernel_constants(const Report& report) {
  const size_t count = report.quick ? 300 : 4000;
  std::vector<Row> ripple, values, gradients;
  for (const char* name : kernels) {
    ripple.push_back(ripple_row(name, count));
    auto [value, gradient] = wave_rows(name, report.quick ? 60 : 400);
    values.push_back(std::move(value)), gradients.push_back(std::move(gradient));
  }
  report.table("constants and ramps: the field as it is, and divided by the sum of the kernel over the sites",
               ripple);
  report.table("SNR (dB) of values, as it is / divided, D4*", values);
  report.table("SNR (dB) of gradients in space, as it is / divided, D4*", gradients);
  const uint32_t edge = report.quick ? 24 : 32;
  report.table("101325 Pa and waves of 50 Pa (rho .3) around it, floats, default kernel",
               {pressure_row("air 0, the default", 0, false, edge),
                pressure_row("air 0, divided", 0, true, edge),
                pressure_row("air 101175, below the signal", 101175, false, edge),
                pressure_row("air 101325", 101325, false, edge),
                pressure_row("air 101325, divided", 101325, true, edge)});
}

} // namespace bccsplat::bench
