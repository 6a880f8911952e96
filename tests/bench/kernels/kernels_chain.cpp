// SPDX-License-Identifier: Apache-2.0
// Samples plane waves on D4* or imports them from frames, evaluates the library's fields and slices at
// points, and splats slices there in plain loops; Cartesian fields of all samples stand beside them.
#include "tests/bench/kernels/kernels_chain.h"

#include <algorithm>
#include <cmath>

#include "field/coefficients/coefficients.h"
#include "field/evaluate.h"
#include "fit/fit.h"
#include "slice/time_slice.h"
#include "tests/bench/kernels/kernel_ripple.h"
#include "tests/bench/kernels/kernels.h"
#include "tests/bench/kernels/kernels_cartesian_field.h"
#include "tests/support/band_limited.h"
#include "tests/support/fields.h"

namespace bccsplat::bench {
namespace {

using test::Grid4;
using test::PlaneWaves;
using test::random_points;
using test::TestContext;

constexpr uint64_t cache = 4ull << 30;
constexpr const char* chain_kernels[] = {"paper", "fast", "radial18+b3", "default", "fine", "gauss09"};

struct Size {
  uint32_t edge;
  int waves;
  size_t points;
  explicit Size(bool quick) : edge(quick ? 30 : 40), waves(quick ? 60 : 300), points(quick ? 500 : 4000) {}
};

double snr_db(std::span<const float> got, std::span<const double> truth) {
  double signal = 0, error = 0;
  for (size_t i = 0; i < got.size(); ++i) {
    const double e = got[i] - truth[i];
    signal += truth[i] * truth[i], error += e * e;
  }
  return 10 * std::log10(signal / error);
}

std::vector<double> values_at(const PlaneWaves& field, const std::vector<Vec4>& points) {
  std::vector<double> values;
  for (const Vec4& p : points) values.push_back(field(p));
  return values;
}

Grid4 sample_grid(uint32_t edge) {
  Grid4 grid;
  for (auto& axis : grid)
    for (uint32_t i = 0; i < edge; ++i) axis.push_back(i);
  return grid;
}

// Samples as a writer gets them: layers evaluated at the sites, or frames to resample. Stored as f32.
MemorySamples through_fit(uint32_t edge, const std::function<void(Fit&)>& feed, const Context& context) {
  FitOptions options;
  options.dims = {edge, edge, edge, edge};
  std::vector<std::vector<BrickLayer>> layers(1);
  Fit fit(
      options,
      [&](int32_t, int, std::span<const BrickLayer> slab) {
        layers[0].insert(layers[0].end(), slab.begin(), slab.end());
      },
      context);
  feed(fit);
  const Lattice4 lattice = fit.finish().lattice;
  return {lattice, {0}, std::move(layers)};
}

MemorySamples sampled_on_d4star(const PlaneWaves& field, uint32_t edge, const Context& context) {
  const auto feed = [&](Fit& fit) {
    const Lattice4 lattice = fit.lattice();
    for (int32_t m = 0; m < lattice.layers(); ++m) {
      const std::vector<double> v = field.on_grid(test::layer_grid(lattice, m));
      fit.add_layer(0, std::vector<float>(v.begin(), v.end()));
    }
  };
  return through_fit(edge, feed, context);
}

MemorySamples imported(const std::vector<double>& samples, uint32_t edge, const Context& context) {
  const size_t frame = size_t{edge} * edge * edge;
  const auto feed = [&](Fit& fit) {
    for (uint32_t t = 0; t < edge; ++t) {
      const std::vector<float> values(samples.begin() + (t * frame), samples.begin() + ((t + 1) * frame));
      FrameBox box;
      box.dims = {edge, edge, edge};
      box.data = values.data();
      fit.add_frame(0, {&box, 1});
    }
  };
  return through_fit(edge, feed, context);
}

// A splat in the literal sense: every site of the slice adds its weighted kernel to the points it reaches.
std::vector<float> splat_at(const Slice& slice, const std::vector<Vec3>& points) {
  std::vector<double> sums(points.size());
  const double radius = slice.kernel.space.radius;
  // Points by unit cell of the lattice units, so that a site finds those near it.
  Int3 cells;
  for (size_t a = 0; a < 3; ++a) cells[a] = static_cast<int32_t>(slice.domain_end[a]) + 1;
  const auto cell_of = [&](const Int3& c) {
    return (static_cast<size_t>(c[2]) * cells[1] + c[1]) * cells[0] + c[0];
  };
  std::vector<std::vector<size_t>> near(cell_of({0, 0, cells[2]}));
  for (size_t i = 0; i < points.size(); ++i) {
    Int3 c;
    for (size_t a = 0; a < 3; ++a) c[a] = static_cast<int32_t>(points[i][a]);
    near[cell_of(c)].push_back(i);
  }
  for (int coset = 0; coset < slice.lattice.cosets(); ++coset) {
    const BrickLayer& layer = slice.coset[coset];
    const Int3 n = layer.dims();
    for (Int3 s{0, 0, 0}; s[2] < n[2]; ++s[2])
      for (s[1] = 0; s[1] < n[1]; ++s[1])
        for (s[0] = 0; s[0] < n[0]; ++s[0]) {
          const double c = layer.value(s[0], s[1], s[2]);
          const Vec3 at = slice.site(coset, s);
          Int3 low, high;
          for (size_t a = 0; a < 3; ++a) {
            low[a] = std::max(0, static_cast<int32_t>(std::floor(at[a] - radius)));
            high[a] = std::min(cells[a] - 1, static_cast<int32_t>(std::floor(at[a] + radius)));
          }
          for (Int3 b = low; b[2] <= high[2]; ++b[2])
            for (b[1] = low[1]; b[1] <= high[1]; ++b[1])
              for (b[0] = low[0]; b[0] <= high[0]; ++b[0])
                for (const size_t i : near[cell_of(b)]) {
                  const Vec3 d{points[i][0] - at[0], points[i][1] - at[1], points[i][2] - at[2]};
                  sums[i] += c * slice.kernel.space.value(dot(d, d));
                }
        }
  }
  std::vector<float> values;
  for (size_t i = 0; i < points.size(); ++i)
    values.push_back(
        static_cast<float>(sums[i] / lattice_sum(slice.kernel, points[i][0], points[i][1], points[i][2])));
  return values;
}

void add_asked(Row& row, std::string_view kernel, const char* for_default, const char* for_fine) {
  row.push_back(word("asked", kernel == "default" ? for_default : kernel == "fine" ? for_fine : "-"));
}

// One row of a table, filled in rho by rho.
struct Lines {
  std::vector<Row> rows;
  std::vector<Series> series;
  explicit Lines(const std::string& title) {
    rows.push_back({word("kernel", title)});
    series.push_back({.title = title, .points = {}, .labels = {}});
  }
  Lines() = default;
  void name(const std::string& title) { *this = Lines(title); }
  void add(double rho, double db) {
    rows[0].push_back(figure("rho " + number(rho, 1), db, 1));
    series[0].points.push_back({rho, db});
  }
};

struct Phases {
  double low = 1e9, high = -1e9;
  void add(double db) { low = std::min(low, db), high = std::max(high, db); }
};

void constants(const Report& report) {
  TestContext context;
  std::vector<Row> rows;
  for (const char* name : chain_kernels)
    for (const LatticeKind kind : {LatticeKind::d4star, LatticeKind::cc}) {
      const Kernel kernel = make_kernel(name);
      if (kind == LatticeKind::cc && kernel.space.radius > 2) continue;
      const auto lattice = Lattice4::fit(kind, {19, 14, 23, 9});
      const MemorySamples samples = test::sample_field(lattice, [](const Vec4&) { return 1.0; });
      const Coefficients c(samples, 0, kernel, 0, cache);
      const auto worst = [&](const std::vector<Vec4>& points) {
        std::vector<float> values(points.size());
        (void)evaluate4(c, points, values, {}, context.get());
        double miss = 0;
        for (const float v : values) miss = std::max(miss, std::abs(static_cast<double>(v) - 1));
        return 20 * std::log10(std::max(miss, 1e-12));
      };
      const auto inside = random_points(lattice, 20000, 1);
      auto border = inside; // on one to four faces of the domain
      for (size_t i = 0; i < border.size(); ++i)
        for (size_t a = 0; a < 4; ++a)
          if ((i + 1) >> a & 1) border[i][a] = i >> (a + 4) & 1 ? lattice.dims[a] - 1.0 : 0;
      rows.push_back(
          {word("kernel", name), word("lattice", kind == LatticeKind::cc ? "CC" : "D4*"),
           kind == LatticeKind::cc ? word("stated dB", "-") : figure("stated dB", dc_ripple_db(kernel, 4), 1),
           figure("inside dB", worst(inside), 1), figure("on the borders dB", worst(border), 1)});
    }
  report.table("Largest error of a constant 1, 4D", rows);
}

} // namespace

void run_kernel_chain(const Report& report) {
  const Size size(report.quick);
  TestContext context;
  const size_t count = std::size(chain_kernels);
  std::vector<Lines> direct(count), import(count);
  std::vector<Row> phases;
  Lines cubic("CC cubic B-spline, interpolating, all samples"), linear("CC linear, all samples");
  for (size_t k = 0; k < count; ++k) direct[k].name(chain_kernels[k]), import[k].name(chain_kernels[k]);
  for (const double rho : wave_rhos) {
    const PlaneWaves field(size.waves, rho, 17);
    const MemorySamples on_sites = sampled_on_d4star(field, size.edge, context.get());
    const Lattice4& lattice = on_sites.lattice();
    const auto points = random_points(lattice, size.points, 19, wave_margin);
    const std::vector<double> truth = values_at(field, points);

    std::vector<double> frames = field.on_grid(sample_grid(size.edge));
    const MemorySamples from_frames = imported(frames, size.edge, context.get());
    // Instants between frames, on the source's grid in space.
    Grid4 grid;
    const double last = size.edge - 1.0;
    for (size_t a = 0; a < 3; ++a)
      for (double x = wave_margin; x <= last - wave_margin; ++x) grid[a].push_back(x);
    for (const double t : {0.13, 1.5, 2.71}) grid[3].push_back(wave_margin + t);
    const std::vector<double> between = field.on_grid(grid);

    const std::array<uint32_t, 4> dims{size.edge, size.edge, size.edge, size.edge};
    const auto cartesian = [&](Lines& line, CartesianKernel kernel) {
      const CartesianField reference(dims, frames, kernel);
      std::vector<float> got;
      for (const Vec4& p : points) got.push_back(static_cast<float>(reference(p)));
      line.add(rho, snr_db(got, truth));
    };
    cartesian(cubic, CartesianKernel::cubic_interpolating);
    cartesian(linear, CartesianKernel::linear);

    for (size_t k = 0; k < count; ++k) {
      const Kernel kernel = make_kernel(chain_kernels[k]);
      const Vec3 unit = lattice.lattice_unit();
      const auto on_slice = [&](double x, double y, double z) {
        return Vec3{x / unit[0], y / unit[1], z / unit[2]};
      };
      {
        const Coefficients c(on_sites, 0, kernel, 0, cache);
        std::vector<float> got(points.size());
        (void)evaluate4(c, points, got, {}, context.get());
        direct[k].add(rho, snr_db(got, truth));

        // Phases of the instant over the distance of two layers of a coset.
        Phases spread;
        double power = 0;
        std::vector<Vec3> at;
        for (const Vec4& p : points) at.push_back(on_slice(p[0], p[1], p[2]));
        for (const double f : truth) power += f * f;
        for (int phase = 0; phase < 8; ++phase) {
          const double t = lattice.layer_frame(lattice.layers() / 2 + 2 * (phase % 2)) +
                           phase / 8.0 * lattice.layer_period() * lattice.time_step;
          const Slice slice = time_slice(c, t, {0, 0}, {}, context.get());
          const std::vector<float> values = splat_at(slice, at);
          double error = 0;
          for (size_t i = 0; i < points.size(); ++i) {
            const double e = values[i] - field({points[i][0], points[i][1], points[i][2], t});
            error += e * e;
          }
          spread.add(10 * std::log10(power / error));
        }
        if (rho == wave_rhos[0]) phases.push_back({word("kernel", chain_kernels[k])});
        Row& row = phases[k];
        row.push_back(word("rho " + number(rho, 1), number(spread.low, 1) + " .. " + number(spread.high, 1)));
        row.push_back(figure("spread " + number(rho, 1), spread.high - spread.low, 2));
      }
      const Coefficients c(from_frames, 0, kernel, 0, cache);
      std::vector<float> got;
      for (const double t : grid[3]) {
        const Slice slice = time_slice(c, t, {0, 0}, {}, context.get());
        std::vector<Vec3> at;
        for (const double z : grid[2])
          for (const double y : grid[1])
            for (const double x : grid[0]) at.push_back(on_slice(x, y, z));
        std::vector<float> values(at.size());
        (void)evaluate(slice, at, values, {});
        got.insert(got.end(), values.begin(), values.end());
      }
      import[k].add(rho, snr_db(got, between));
    }
  }
  const auto table = [&](const std::string& title, std::vector<Lines>& lines, const char* for_default,
                         const char* for_fine, bool references) {
    std::vector<Row> rows;
    for (size_t k = 0; k < count; ++k) {
      rows.push_back(lines[k].rows[0]);
      add_asked(rows.back(), chain_kernels[k], for_default, for_fine);
    }
    if (references)
      for (Lines* l : {&linear, &cubic}) {
        rows.push_back(l->rows[0]);
        add_asked(rows.back(), "", "", "");
      }
    report.table(title, rows);
  };
  table("SNR (dB): D4* sampled directly, random 4D points", direct, "50 / 32.5 / 18", "59 / 40 / 21.5", true);
  table("SNR (dB): CC frames imported (Kaiser 8), time slices between frames on the CC grid", import,
        "47.5 / 31 / 17.5", "54 / 38.5 / 20.5", false);
  report.table(
      "SNR (dB): slice, 3D coefficients, splat at random points; lowest .. highest of 8 phases of t1",
      phases);
  constants(report);

  Plot plot{.title = "From samples to values: error of plane waves of a ball, measured",
            .x_label = "rho (fraction of the Nyquist frequency of CC)",
            .y_label = "signal to error, dB",
            .series = {}};
  for (size_t k = 0; k < count; ++k) {
    plot.series.push_back(direct[k].series[0]);
    plot.series.back().title = std::string("D4* ") + chain_kernels[k] + ", sampled directly";
  }
  for (const Lines* l : {&linear, &cubic}) plot.series.push_back(l->series[0]);
  report.plot("chain", plot);
}

} // namespace bccsplat::bench
