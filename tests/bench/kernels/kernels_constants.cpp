// SPDX-License-Identifier: Apache-2.0
// What becomes of a constant, and of what varies little around a large one.
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>

#include "field/coefficients/coefficients.h"
#include "field/evaluate.h"
#include "fit/fit.h"
#include "store/based_layers.h"
#include "tests/bench/fit/fit_source.h"
#include "tests/bench/kernels/kernels_chain.h"
#include "tests/bench/kernels/wave_error.h"
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

// How the field is read: above air, so and divided by the lattice sum, or above the base that readers take.
enum class Reading { above_air, divided, above_base };

// A constant with waves around it, as a host has it.
struct Around {
  std::string what;
  double constant = 101325, signal = 50, air = 0;
  SourceType type = SourceType::f32;
};

template<class T> FitSource source_around(const Around& a, const test::PlaneWaves& waves, uint32_t edge) {
  FitSource source{a.what, {edge, edge, edge, edge}, a.type, {}};
  for (uint32_t t = 0; t < edge; ++t)
    for (uint32_t z = 0; z < edge; ++z)
      for (uint32_t y = 0; y < edge; ++y)
        for (uint32_t x = 0; x < edge; ++x) {
          const double v = a.constant + a.signal * waves({1.0 * x, 1.0 * y, 1.0 * z, 1.0 * t});
          const T value = std::is_integral_v<T> ? static_cast<T>(std::llround(v)) : static_cast<T>(v);
          const auto* bytes = reinterpret_cast<const std::byte*>(&value);
          source.bytes.insert(source.bytes.end(), bytes, bytes + sizeof value);
        }
  return source;
}

// Through the fit, floats relative to air as a file holds them, and back.
Row around_row(const Around& a, Reading reading, uint32_t edge) {
  test::TestContext context;
  const test::PlaneWaves waves(60, 0.3, 5);
  const FitSource source = a.type == SourceType::i32 ? source_around<int32_t>(a, waves, edge)
                                                     : source_around<float>(a, waves, edge);
  const auto air = static_cast<float>(a.air);
  FitOptions options;
  options.dims = source.dims;
  options.channels[0].quantiser = quantiser_of_source(a.type, air);
  std::vector<BrickLayer> made;
  Fit fit(
      options,
      [&](int32_t, int, std::span<const BrickLayer> slab) {
        made.insert(made.end(), slab.begin(), slab.end());
      },
      context.get());
  for (uint32_t t = 0; t < edge; ++t) {
    const FrameBox box = source.box(t);
    fit.add_frame(0, {&box, 1});
  }
  const Lattice4 lattice = fit.finish().lattice;
  LayerWindow above_air(lattice, air);
  BasedLayers above_base(above_air);
  for (const BrickLayer& layer : made) above_base.see(SampleLayer(layer)), above_air.push(layer);
  const bool based = reading == Reading::above_base && above_base.far_from_air();
  if (based) above_base.settle();
  const Coefficients c(based ? static_cast<const SampleSource&>(above_base) : above_air, 0,
                       make_kernel("default"), 0, 4ull << 30);
  const std::vector<Vec4> points = test::random_points(lattice, 2000, 5, 10);
  std::vector<float> values(points.size());
  std::vector<std::array<float, 4>> gradients(points.size());
  (void)evaluate4(c, points, values, gradients, context.get());
  double error = 0, steep_error = 0, steep = 0;
  const Vec3 unit = lattice.lattice_unit();
  for (size_t i = 0; i < points.size(); ++i) {
    Sum got{values[i] - a.air, {}};
    for (size_t k = 0; k < 3; ++k) got.gradient[k] = gradients[i][k] * unit[k];
    if (reading == Reading::divided) {
      const Vec4& p = points[i];
      got = got.over(ones_at(c.kernel(), {p[0] / unit[0], p[1] / unit[1], p[2] / unit[2], p[3]}));
    }
    const Vec4 g = waves.gradient(points[i]);
    error += std::norm(got.value + a.air - a.constant - a.signal * waves(points[i]));
    for (size_t k = 0; k < 3; ++k) {
      steep += std::pow(a.signal * g[k], 2);
      steep_error += std::norm(got.gradient[k] / unit[k] - a.signal * g[k]);
    }
  }
  return {word("field", a.what),
          figure("RMS error", std::sqrt(error / static_cast<double>(points.size())), 3),
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
  const auto row = [&](const Around& a, Reading reading) { return around_row(a, reading, edge); };
  report.table("101325 Pa and waves of 50 Pa (rho .3) around it, floats, default kernel",
               {row({.what = "air 0, as base"}, Reading::above_air),
                row({.what = "air 0, divided"}, Reading::divided),
                row({.what = "air 0, as readers do"}, Reading::above_base),
                row({.what = "air 101175, below the signal, as base", .air = 101175}, Reading::above_air),
                row({.what = "air 101175, as readers do", .air = 101175}, Reading::above_base),
                row({.what = "air 101325", .air = 101325}, Reading::above_air),
                row({.what = "air 101325, divided", .air = 101325}, Reading::divided)});
  const auto large = [&](const char* what, double air, SourceType type, Reading reading) {
    return row({.what = what, .constant = 2e9, .signal = 100, .air = air, .type = type}, reading);
  };
  report.table("2e9 and waves of 100 around it, stored as floats relative to air",
               {large("i32, air 0, as base", 0, SourceType::i32, Reading::above_air),
                large("i32, air 0, as readers do", 0, SourceType::i32, Reading::above_base),
                large("i32, air 2e9", 2e9, SourceType::i32, Reading::above_base),
                large("f32, air 0, as readers do", 0, SourceType::f32, Reading::above_base),
                large("f32, air 2e9", 2e9, SourceType::f32, Reading::above_base)});
  report_constant_files(report);
}

} // namespace bccsplat::bench
