// SPDX-License-Identifier: Apache-2.0
// Compares gradients of plane waves: the kernels' own on D4*, differences of its values a step apart, and
// those of Cartesian fields of all samples.
#include <cmath>

#include "field/coefficients/coefficients.h"
#include "field/evaluate.h"
#include "tests/bench/kernels/kernels.h"
#include "tests/bench/kernels/kernels_cartesian_field.h"
#include "tests/bench/kernels/kernels_chain.h"
#include "tests/support/band_limited.h"
#include "tests/support/dense_layer.h"
#include "tests/support/fields.h"

namespace bccsplat::bench {
namespace {

using test::PlaneWaves;
using test::TestContext;

// A field by its values at many points.
using FieldValues = std::function<std::vector<double>(const std::vector<Vec4>&)>;

// Differences of values a step h apart along x, y and z: central (order 2), or of order 4.
std::vector<Vec3> differences(const FieldValues& values, const std::vector<Vec4>& points, double h,
                              int order) {
  std::vector<Vec3> slopes(points.size());
  for (size_t a = 0; a < 3; ++a)
    for (const int k : {1, 2}) {
      if (2 * k > order) continue;
      const double weight = order == 2 ? 0.5 / h : (k == 1 ? 8.0 : -1.0) / (12 * h);
      for (const int sign : {-1, 1}) {
        std::vector<Vec4> shifted = points;
        for (Vec4& p : shifted) p[a] += sign * k * h;
        const std::vector<double> at = values(shifted);
        for (size_t i = 0; i < points.size(); ++i) slopes[i][a] += sign * weight * at[i];
      }
    }
  return slopes;
}

struct Table {
  std::vector<Row> rows;
  size_t next = 0;
  void add(const std::string& field, const std::string& gradient, int values, double rho, double db) {
    if (next == rows.size())
      rows.push_back({word("field", field), word("gradient", gradient), figure("evaluations", values, 0)});
    rows[next++].push_back(figure("rho " + number(rho, 1), db, 1));
  }
};

} // namespace

void run_kernel_gradients(const Report& report) {
  TestContext context;
  const uint32_t edge = report.quick ? 30 : 40;
  const std::array<uint32_t, 4> dims{edge, edge, edge, edge};
  const auto lattice = Lattice4::fit(LatticeKind::d4star, dims);
  const auto points = test::random_points(lattice, report.quick ? 300 : 2500, 29, wave_margin);
  Table table;
  for (const double rho : table_rhos) {
    table.next = 0;
    const PlaneWaves field(report.quick ? 60 : 200, rho, 37);
    std::vector<Vec4> truth;
    for (const Vec4& p : points) truth.push_back(field.gradient(p));
    const auto snr = [&](const auto& slopes) {
      double signal = 0, error = 0;
      for (size_t i = 0; i < points.size(); ++i)
        for (size_t a = 0; a < 3; ++a) {
          const double e = static_cast<double>(slopes[i][a]) - truth[i][a];
          signal += truth[i][a] * truth[i][a], error += e * e;
        }
      return 10 * std::log10(signal / error);
    };
    const auto by_differences = [&](const std::string& name, const FieldValues& values) {
      for (const double h : {0.25, 0.5, 1.0})
        table.add(name, "central, h = " + number(h, 2) + " T", 6, rho,
                  snr(differences(values, points, h, 2)));
      for (const double h : {0.5, 1.0})
        table.add(name, "order 4, h = " + number(h, 2) + " T", 12, rho,
                  snr(differences(values, points, h, 4)));
    };
    {
      test::Grid4 grid;
      for (auto& axis : grid)
        for (uint32_t i = 0; i < edge; ++i) axis.push_back(i);
      const std::vector<double> samples = field.on_grid(grid);
      struct Reference {
        const char* name;
        CartesianKernel kernel;
      };
      for (const Reference& r : {Reference{"CC linear", CartesianKernel::linear},
                                 Reference{"CC Catmull-Rom", CartesianKernel::catmull_rom},
                                 Reference{"CC cubic B-spline", CartesianKernel::cubic_interpolating}}) {
        const CartesianField cc(dims, samples, r.kernel);
        if (r.kernel != CartesianKernel::linear) {
          std::vector<Vec4> slopes(points.size());
          for (size_t i = 0; i < points.size(); ++i) (void)cc(points[i], &slopes[i]);
          table.add(r.name, "analytic", 1, rho, snr(slopes));
        }
        const FieldValues values = [&](const std::vector<Vec4>& at) {
          std::vector<double> v;
          for (const Vec4& p : at) v.push_back(cc(p));
          return v;
        };
        if (r.kernel != CartesianKernel::catmull_rom)
          table.add(r.name, "central, h = 1.00 T", 6, rho, snr(differences(values, points, 1, 2)));
      }
    }
    std::vector<std::vector<BrickLayer>> layers(1);
    for (int32_t m = 0; m < lattice.layers(); ++m) {
      const std::vector<double> v = field.on_grid(test::layer_grid(lattice, m));
      layers[0].push_back(
          test::layer_from_dense(lattice.space, lattice.coset(m), std::vector<float>(v.begin(), v.end())));
    }
    const MemorySamples samples(lattice, {0}, std::move(layers));
    for (const char* name : {"fast", "radial18+b3", "default", "fine", "gauss09"}) {
      const Coefficients c(samples, 0, make_kernel(name), 0, 4ull << 30);
      std::vector<float> at(points.size());
      std::vector<std::array<float, 4>> slopes(points.size());
      (void)evaluate4(c, points, at, slopes, context.get());
      table.add(std::string("D4* ") + name, "analytic", 1, rho, snr(slopes));
      if (name != std::string_view("default") && name != std::string_view("fine")) continue;
      by_differences(std::string("D4* ") + name, [&](const std::vector<Vec4>& where) {
        std::vector<float> v(where.size());
        (void)evaluate4(c, where, v, {}, context.get());
        return std::vector<double>(v.begin(), v.end());
      });
    }
  }
  report.table("SNR (dB) of the gradient in space, 4D plane waves, random points", table.rows);
}

} // namespace bccsplat::bench
