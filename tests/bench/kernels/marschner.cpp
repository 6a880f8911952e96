// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "field/coefficients/coefficients.h"
#include "field/evaluate.h"
#include "tests/bench/kernels/kernel_ripple.h"
#include "tests/bench/kernels/kernels_cartesian_field.h"
#include "tests/bench/kernels/kernels_chain.h"
#include "tests/support/band_limited.h"
#include "tests/support/fields.h"

namespace bccsplat::bench {
namespace {

using test::MarschnerLobb;
using test::TestContext;

constexpr double spacing = 0.05; // T
constexpr uint32_t edge = 41;    // samples of CC per axis on [-1, 1]

Vec3 unit_of(double x, double y, double z) { return {x * spacing - 1, y * spacing - 1, z * spacing - 1}; }

struct Errors {
  double square = 0, largest = 0;
  size_t count = 0;
  void add(double e) {
    square += e * e, largest = std::max(largest, std::abs(e));
    ++count;
  }
  [[nodiscard]] double rms() const { return std::sqrt(square / static_cast<double>(count)); }
  void finish(Row& row, const std::string& of) const {
    row.push_back(figure(of + " PSNR dB", -20 * std::log10(rms()), 2));
    row.push_back(figure(of + " largest %", 100 * largest, 2));
  }
};

struct Signal {
  std::string name;
  MarschnerLobb field;
};

} // namespace

void run_marschner_lobb(const Report& report) {
  TestContext context;
  const size_t count = report.quick ? 2000 : 20000;
  const auto lattice = Lattice4::fit(LatticeKind::d4star, {edge, edge, edge, 1});
  std::vector<Vec4> points; // in [-0.9, 0.9]
  for (const Vec4& p : test::random_points(lattice, count, 3, 0.1 / spacing))
    points.push_back({p[0], p[1], p[2], 0});

  std::vector<Signal> signals;
  signals.push_back({"as published", MarschnerLobb()});
  for (const double rho : {1.0, 0.9, 0.8, 0.7})
    signals.push_back({"ball " + number(rho, 1), MarschnerLobb(rho * 0.5 / spacing)});

  constexpr const char* names[] = {"paper", "radial16+b2", "radial18+b3", "default", "fine", "gauss09"};
  struct Reference {
    const char* name;
    CartesianKernel kernel;
    int taps;
  };
  constexpr Reference references[] = {
      {"CC linear", CartesianKernel::linear, 8},
      {"CC Catmull-Rom", CartesianKernel::catmull_rom, 64},
      {"CC cubic B-spline, interpolating", CartesianKernel::cubic_interpolating, 64}};
  std::vector<Row> rows;
  for (const Reference& r : references)
    rows.push_back({word("kernel", r.name), figure("samples", double(edge) * edge * edge, 0),
                    figure("taps", r.taps, 0)});
  for (const char* name : names)
    rows.push_back({word("kernel", std::string("BCC ") + name), figure("samples", double(lattice.sites()), 0),
                    figure("taps", mean_taps(make_kernel(name), 3), 0)});
  for (const Signal& s : signals) {
    std::vector<double> truth, grid;
    for (const Vec4& p : points) truth.push_back(s.field(unit_of(p[0], p[1], p[2])));
    for (uint32_t z = 0; z < edge; ++z)
      for (uint32_t y = 0; y < edge; ++y)
        for (uint32_t x = 0; x < edge; ++x) grid.push_back(s.field(unit_of(x, y, z)));
    size_t row = 0;
    for (const Reference& r : references) {
      const CartesianField field({edge, edge, edge, 1}, grid, r.kernel);
      Errors e;
      for (size_t i = 0; i < points.size(); ++i) e.add(field(points[i]) - truth[i]);
      e.finish(rows[row++], s.name);
    }
    const MemorySamples samples =
        test::sample_field(lattice, [&](const Vec4& p) { return s.field(unit_of(p[0], p[1], p[2])); });
    for (const char* name : names) {
      const Coefficients c(samples, 0, make_kernel(name), 0, 1ull << 30);
      std::vector<float> got(points.size());
      (void)evaluate4(c, points, got, {}, context.get());
      Errors e;
      for (size_t i = 0; i < points.size(); ++i) e.add(got[i] - truth[i]);
      e.finish(rows[row++], s.name);
    }
  }
  report.table("Marschner-Lobb, T = .05, points in [-.9, .9]^3 (PSNR: peak 1)", rows);
}

} // namespace bccsplat::bench
