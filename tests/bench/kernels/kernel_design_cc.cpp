// SPDX-License-Identifier: Apache-2.0
// Fits polynomials of neighbour sums to plane waves, space and time apart, and writes them as stages by
// Horner's scheme; a penalty on their square grows until the response at the sites is bounded.
#include "tests/bench/kernels/kernel_design_cc.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iomanip>
#include <numbers>
#include <random>

#include "kernel/radial.h"

namespace bccsplat::bench {
namespace {

constexpr std::array<double, 4> cc_rhos{0.3, 0.5, 0.7, 0.9};
constexpr double tau = 2 * std::numbers::pi;

// A plane wave: what reconstruction needs of the kernel there, and the values of the polynomial's terms.
struct CcWave {
  double own = 0;     // transform of the kernel at the wave itself
  double sum = 0;     // over the dual lattice: the response at the sites without a prefilter
  double squares = 0; // of the transform over the dual lattice
  std::vector<double> terms;
};

std::vector<double> solve_pivoted(std::vector<std::vector<long double>> a, std::vector<long double> b) {
  const size_t n = b.size();
  for (size_t i = 0; i < n; ++i) {
    size_t pivot = i;
    for (size_t r = i + 1; r < n; ++r)
      if (std::fabs(a[r][i]) > std::fabs(a[pivot][i])) pivot = r;
    std::swap(a[i], a[pivot]), std::swap(b[i], b[pivot]);
    for (size_t r = i + 1; r < n; ++r) {
      const long double f = a[r][i] / a[i][i];
      for (size_t c = i; c < n; ++c) a[r][c] -= f * a[i][c];
      b[r] -= f * b[i];
    }
  }
  std::vector<double> x(n);
  for (size_t i = n; i-- > 0;) {
    for (size_t c = i + 1; c < n; ++c) b[i] -= a[i][c] * static_cast<long double>(x[c]);
    x[i] = static_cast<double>(b[i] / a[i][i]);
  }
  return x;
}

double response_of(const std::vector<double>& q, const CcWave& w) {
  double sum = 0;
  for (size_t i = 0; i < q.size(); ++i) sum += q[i] * w.terms[i];
  return sum;
}

// (q own - 1)^2 + q^2 (squares - own^2): error power of a wave of power 1.
double cc_snr(const std::vector<CcWave>& waves, const std::function<double(const CcWave&)>& q) {
  double error = 0;
  for (const CcWave& w : waves) {
    const double v = q(w);
    error += v * v * w.squares - 2 * v * w.own + 1;
  }
  return -10 * std::log10(error / static_cast<double>(waves.size()));
}

struct CcFit {
  std::vector<double> q;
  CcDesign design;
};

// bands: waves of each rho; all: over every frequency of the cell, where the magnitude of the response at the
// sites is kept below 1.2 by as small a penalty on the square of the prefilter as does. (It cannot be 1
// everywhere: at the corners of the cell these kernels' sums over CC are slightly negative.)
CcFit fit(const std::vector<std::vector<CcWave>>& bands, const std::vector<CcWave>& all) {
  CcFit f;
  const size_t n = bands[0][0].terms.size();
  for (double penalty = 1e-9; penalty < 1; penalty *= 2) {
    std::vector<std::vector<long double>> a(n, std::vector<long double>(n));
    std::vector<long double> b(n);
    const auto add = [&](const CcWave& w, double quadratic, double linear) {
      for (size_t i = 0; i < n; ++i) {
        b[i] += static_cast<long double>(linear * w.terms[i]);
        for (size_t j = 0; j < n; ++j)
          a[i][j] += static_cast<long double>(quadratic * w.terms[i] * w.terms[j]);
      }
    };
    for (const auto& band : bands) {
      double least = 0;
      for (const CcWave& w : band) least += 1 - w.own * w.own / w.squares;
      for (const CcWave& w : band) add(w, w.squares / least, w.own / least);
    }
    for (const CcWave& w : all) add(w, penalty, 0);
    f.q = solve_pivoted(a, b);
    f.design.lowest = f.design.highest = 1;
    for (const CcWave& w : all) {
      const double response = response_of(f.q, w) * w.sum;
      f.design.lowest = std::min(f.design.lowest, response),
      f.design.highest = std::max(f.design.highest, response);
    }
    if (f.design.lowest >= -1.2 && f.design.highest <= 1.2) break;
  }
  for (size_t r = 0; r < cc_rhos.size(); ++r) {
    f.design.snr[r] = cc_snr(bands[r], [&](const CcWave& w) { return response_of(f.q, w); });
    f.design.best[r] = cc_snr(bands[r], [](const CcWave& w) { return w.own / w.squares; });
  }
  return f;
}

// Sum of |taps| of sum_j (p_j + x_j X) S^j on a grid, S and X means.
double gain_in_space(const std::vector<double>& q, int degree) {
  const int reach = degree + 1, n = 2 * reach + 1;
  const auto at = [n](int x, int y, int z) { return static_cast<size_t>((z * n + y) * n + x); };
  using Taps = std::vector<double>;
  Taps power(static_cast<size_t>(n * n * n)), total = power;
  power[at(reach, reach, reach)] = 1;
  const auto spread = [&](const Taps& in, bool corners) {
    Taps out(in.size());
    for (int z = 1; z < n - 1; ++z)
      for (int y = 1; y < n - 1; ++y)
        for (int x = 1; x < n - 1; ++x)
          for (int dz = -1; dz <= 1; ++dz)
            for (int dy = -1; dy <= 1; ++dy)
              for (int dx = -1; dx <= 1; ++dx) {
                const int far = std::abs(dx) + std::abs(dy) + std::abs(dz);
                if (far == (corners ? 3 : 1))
                  out[at(x + dx, y + dy, z + dz)] += in[at(x, y, z)] / (corners ? 8 : 6);
              }
    return out;
  };
  for (int j = 0; j <= degree; ++j) {
    const Taps cornered = spread(power, true);
    for (size_t i = 0; i < total.size(); ++i) {
      total[i] += q[2 * j] * power[i];
      if (j < degree) total[i] += q[static_cast<size_t>(2 * j) + 1] * cornered[i];
    }
    power = spread(power, false);
  }
  double sum = 0;
  for (const double v : total) sum += std::fabs(v);
  return sum;
}

CcWave space_wave(const std::function<double(double)>& transform, const std::array<double, 3>& xi,
                  int degree) {
  CcWave w;
  for (int i = -3; i <= 3; ++i)
    for (int j = -3; j <= 3; ++j)
      for (int k = -3; k <= 3; ++k) {
        const double v = transform(std::hypot(xi[0] + i, xi[1] + j, xi[2] + k));
        w.sum += v, w.squares += v * v;
        if (i == 0 && j == 0 && k == 0) w.own = v;
      }
  const double cx = std::cos(tau * xi[0]), cy = std::cos(tau * xi[1]), cz = std::cos(tau * xi[2]);
  double power = 1;
  for (int j = 0; j <= degree; ++j, power *= (cx + cy + cz) / 3) {
    w.terms.push_back(power);
    if (j < degree) w.terms.push_back(power * cx * cy * cz);
  }
  return w;
}

CcWave time_wave(int order, double xi, int degree) {
  CcWave w;
  for (int n = -8; n <= 8; ++n) {
    const double x = std::numbers::pi * (xi + n);
    const double v = std::pow(std::fabs(x) < 1e-12 ? 1.0 : std::sin(x) / x, order);
    w.sum += v, w.squares += v * v;
    if (n == 0) w.own = v;
  }
  double power = 1;
  for (int j = 0; j <= degree; ++j, power *= std::cos(tau * xi)) w.terms.push_back(power);
  return w;
}

void print_cc_stages(std::ostream& out, const CcDesign& d, const std::string& name) {
  out << "constexpr PrefilterStage " << name << "[] = {\n";
  for (const PrefilterStage& s : d.stages)
    out << "    {" << s.self << ", " << s.spatial << ", " << s.temporal << ", 0, " << s.cross << ", "
        << s.source << ", 0, 0, 0},\n";
  out << "};\n";
}

} // namespace

CcDesign design_cc_space(const RadialKernel& phi, int stages) {
  // Transform of phi by length of frequency: 4 pi int r^2 phi sinc(2 pi k r) dr, tabulated.
  constexpr double step = 1.0 / 256;
  std::vector<double> table;
  for (double k = 0; k < 6.5; k += step) {
    constexpr int parts = 1000;
    double sum = 0;
    for (int i = 0; i < parts; ++i) {
      const double r = phi.radius * (i + 0.5) / parts, x = tau * k * r;
      sum += r * r * phi.value(r * r) * (x < 1e-9 ? 1 : std::sin(x) / x);
    }
    table.push_back(2 * tau * sum * phi.radius / parts);
  }
  const auto transform = [&](double k) {
    const auto i = static_cast<size_t>(k / step);
    const double f = k / step - static_cast<double>(i);
    return i + 1 < table.size() ? table[i] * (1 - f) + table[i + 1] * f : 0.0;
  };
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<std::vector<CcWave>> bands;
  for (const double rho : cc_rhos) {
    auto& band = bands.emplace_back();
    while (band.size() < 2000) {
      const std::array<double, 3> u{uniform(random), uniform(random), uniform(random)};
      if (u[0] * u[0] + u[1] * u[1] + u[2] * u[2] > 1) continue;
      band.push_back(space_wave(transform, {u[0] * rho / 2, u[1] * rho / 2, u[2] * rho / 2}, stages));
    }
  }
  std::vector<CcWave> all;
  constexpr int grid = 10; // steps of an eighth of the cell
  for (int i = 0; i <= grid; ++i)
    for (int j = 0; j <= i; ++j)
      for (int k = 0; k <= j; ++k)
        all.push_back(space_wave(transform, {0.5 * i / grid, 0.5 * j / grid, 0.5 * k / grid}, stages));
  CcFit f = fit(bands, all);
  f.design.gain = gain_in_space(f.q, stages);
  // Horner in S: c <- S c + (p_j + x_j X) f.
  const auto p = [&](int j) { return f.q[2 * j]; };
  const auto x = [&](int j) { return f.q[static_cast<size_t>(2 * j) + 1]; };
  for (int j = stages - 1; j >= 0; --j) {
    PrefilterStage s;
    const bool first = j == stages - 1;
    s.self = first ? p(j) : 0;
    s.spatial = (first ? p(stages) : 1) / 6;
    s.cross = x(j) / 8;
    s.source = first ? 0 : p(j);
    f.design.stages.push_back(s);
  }
  return f.design;
}

CcDesign design_cc_time(int order, int stages) {
  std::vector<std::vector<CcWave>> bands;
  constexpr int samples = 500;
  for (const double rho : cc_rhos) {
    auto& band = bands.emplace_back();
    // The density of one coordinate of points uniform in a 4D ball: (1 - u^2)^(3/2), by repetition.
    for (int i = 0; i < samples; ++i) {
      const double u = (i + 0.5) / samples;
      const int times = 1 + static_cast<int>(8 * std::pow(1 - u * u, 1.5));
      for (int k = 0; k < times; ++k) band.push_back(time_wave(order, u * rho / 2, stages));
    }
  }
  std::vector<CcWave> all;
  for (int i = 0; i <= 100; ++i) all.push_back(time_wave(order, 0.005 * i, stages));
  CcFit f = fit(bands, all);
  // Taps of cos^j, by convolution.
  std::vector<double> total(static_cast<size_t>(2 * stages + 1)), power = total;
  power[stages] = 1;
  for (int j = 0; j <= stages; ++j) {
    std::vector<double> next(power.size());
    for (size_t i = 0; i < power.size(); ++i) {
      total[i] += f.q[j] * power[i];
      if (i > 0) next[i - 1] += power[i] / 2;
      if (i + 1 < power.size()) next[i + 1] += power[i] / 2;
    }
    power = next;
  }
  for (const double v : total) f.design.gain += std::fabs(v);
  for (int j = stages - 1; j >= 0; --j) {
    PrefilterStage s;
    const bool first = j == stages - 1;
    s.self = first ? f.q[j] : 0;
    s.temporal = (first ? f.q[stages] : 1) / 2;
    s.source = first ? 0 : f.q[j];
    f.design.stages.push_back(s);
  }
  return f.design;
}

void print_cc_designs(std::ostream& out) {
  out << "// Made by `bccsplat_bench kernels --design-cc`. A line holds self, spatial, temporal, mixed, "
         "cross, "
         "source and\n"
         "// the other weights of the samples; above it dB at rho .3 .5 .7 .9 in space or time alone, and in "
         "brackets\n"
         "// what the best of all prefilters reaches.\n"
      << std::setprecision(9);
  const auto comment = [&](const CcDesign& d) {
    out << "// " << std::fixed << std::setprecision(1);
    for (const double v : d.snr) out << v << ' ';
    out << "(";
    for (size_t i = 0; i < 4; ++i) out << d.best[i] << (i < 3 ? " " : "");
    out << "), response at the sites " << std::setprecision(2) << d.lowest << " to " << d.highest << "\n"
        << std::defaultfloat << std::setprecision(9);
  };
  std::string spaces, times;
  for (const auto& [name, stages] : {std::pair{"radial16", 2}, {"radial18", 3}, {"radial20", 3}}) {
    RadialKernel phi = make_kernel(std::string(name) + "+b3").space;
    const double integral = radial_integral(phi);
    for (double& a : phi.a) a /= integral;
    const CcDesign d = design_cc_space(phi, stages);
    comment(d);
    print_cc_stages(out, d, std::string(name) + "_cc");
    spaces += "    {\"" + std::string(name) + "\", " + name + "_cc, " + std::to_string(d.gain) + "},\n";
  }
  for (const auto& [order, stages] : {std::pair{2, 1}, {3, 3}, {4, 5}}) {
    const CcDesign d = design_cc_time(order, stages);
    comment(d);
    print_cc_stages(out, d, "b" + std::to_string(order) + "_cc");
    times += "    {" + std::to_string(order) + ", b" + std::to_string(order) + "_cc, " +
             std::to_string(d.gain) + "},\n";
  }
  out << "struct CcSpace {\n  std::string_view name;\n  std::span<const PrefilterStage> stages;\n  double "
         "gain; // sum "
         "of |taps|\n};\nconstexpr CcSpace cc_space[] = {\n"
      << spaces
      << "};\nstruct CcTime {\n  int order;\n  std::span<const PrefilterStage> stages;\n  double "
         "gain;\n};\nconstexpr "
         "CcTime cc_time[] = {\n"
      << times << "};\n";
}

} // namespace bccsplat::bench
