// SPDX-License-Identifier: Apache-2.0
// The pipeline of Neophytou & Mueller 2002 on plane waves, step by step as it is printed, beside the
// library's `paper` and `default`.
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "field/coefficients/coefficients.h"
#include "field/evaluate.h"
#include "slice/time_slice.h"
#include "tests/bench/kernels/kernels_chain.h"
#include "tests/support/band_limited.h"
#include "tests/support/dense_layer.h"
#include "tests/support/fields.h"

namespace bccsplat::bench {
namespace {

using test::PlaneWaves;
using test::TestContext;

constexpr double a = 2;           // exp(-a r^2), cut at
constexpr double gauss_reach = 2; // T

double gauss(double r2) { return r2 <= gauss_reach * gauss_reach ? std::exp(-a * r2) : 0; }

// A lattice with its samples at hand. D4*, or CC.
struct PaperField {
  Lattice4 lattice;
  std::vector<std::vector<float>> layers; // by layer, x fastest

  // Of samples that lie inside; points and sites stay `wave_margin` away from the ends.
  [[nodiscard]] double at(int32_t layer, const Int3& i) const {
    const Int3 n = lattice.space.dims(lattice.coset(layer));
    return layers[layer][(static_cast<size_t>(i[2]) * n[1] + i[1]) * n[0] + i[0]];
  }
};

PaperField sampled(const PlaneWaves& waves, LatticeKind kind, uint32_t edge) {
  PaperField field{Lattice4::fit(kind, {edge, edge, edge, edge}), {}};
  for (int32_t m = 0; m < field.lattice.layers(); ++m) {
    const std::vector<double> v = waves.on_grid(test::layer_grid(field.lattice, m));
    field.layers.emplace_back(v.begin(), v.end());
  }
  return field;
}

MemorySamples memory_samples(const PaperField& field) {
  std::vector<std::vector<BrickLayer>> layers(1);
  for (int32_t m = 0; m < field.lattice.layers(); ++m)
    layers[0].push_back(test::layer_from_dense(field.lattice.space, field.lattice.coset(m), field.layers[m]));
  return {field.lattice, {0}, std::move(layers)};
}

// Sites of a coset of the spatial lattice within reach of a point (T); body(site, r^2).
template<class Body> void near(const Lattice3& space, int coset, const Vec3& p, const Body& body) {
  const double plane = space.plane_distance(), pitch = space.bcc ? 2 * plane : plane;
  Int3 low, high;
  for (size_t k = 0; k < 3; ++k) {
    low[k] = static_cast<int32_t>(std::ceil((p[k] - gauss_reach - coset * plane) / pitch));
    high[k] = static_cast<int32_t>(std::floor((p[k] + gauss_reach - coset * plane) / pitch));
  }
  for (Int3 i = low; i[2] <= high[2]; ++i[2])
    for (i[1] = low[1]; i[1] <= high[1]; ++i[1])
      for (i[0] = low[0]; i[0] <= high[0]; ++i[0]) {
        double r2 = 0;
        for (size_t k = 0; k < 3; ++k) r2 += std::pow(plane * space.plane(coset, i[k]) - p[k], 2);
        if (r2 <= gauss_reach * gauss_reach) body(i, r2);
      }
}

// Value of a slice at t1 (T) at a site of its lattice.
using SliceValue = std::function<double(int coset, const Int3& site, double t1)>;

// Section 4.1: a weighted mean of the samples above and below, in the site's own coset.
SliceValue approximate(const PaperField& f) {
  return [&f](int coset, const Int3& site, double t1) {
    const double distance = f.lattice.layer_distance();
    double sum = 0, weights = 0;
    for (auto m = static_cast<int32_t>(std::ceil((t1 - gauss_reach) / distance));
         m * distance <= t1 + gauss_reach; ++m) {
      if (f.lattice.coset(m) != coset) continue;
      const double w = std::exp(-a * std::pow(m * distance - t1, 2));
      sum += w * f.at(m, site), weights += w;
    }
    return sum / weights;
  };
}

// Equation (6): all samples within reach in 4D, of both cosets.
SliceValue accurate(const PaperField& f) {
  return [&f](int coset, const Int3& site, double t1) {
    const double distance = f.lattice.layer_distance(), plane = f.lattice.space.plane_distance();
    Vec3 p;
    for (size_t k = 0; k < 3; ++k) p[k] = plane * f.lattice.space.plane(coset, site[k]);
    double sum = 0, weights = 0;
    for (auto m = static_cast<int32_t>(std::ceil((t1 - gauss_reach) / distance));
         m * distance <= t1 + gauss_reach; ++m)
      near(f.lattice.space, f.lattice.coset(m), p, [&](const Int3& i, double r2) {
        const double w = gauss(r2 + std::pow(m * distance - t1, 2));
        sum += w * f.at(m, i), weights += w;
      });
    return sum / weights;
  };
}

// Section 4.2 by neighbours: of the site's own coset the two samples above and below (A), of the other coset
// the 8 around it in the layer between these (B), and the 6 along the axes in the nearer one of its own (C).
// Their Gaussian weights are divided by their sum. On CC, whose cosets are one, B are none.
SliceValue by_neighbours(const PaperField& f, bool with_b, bool with_c) {
  return [&f, with_b, with_c](int coset, const Int3& site, double t1) {
    const Lattice4& l = f.lattice;
    const double distance = l.layer_distance(), plane = l.space.plane_distance();
    auto below = static_cast<int32_t>(std::floor(t1 / distance));
    while (l.coset(below) != coset) --below;
    const int32_t above = below + l.layer_period();
    double sum = 0, weights = 0;
    const auto add = [&](int32_t layer, const Int3& i, double r2) {
      const double w = std::exp(-a * (r2 + std::pow(layer * distance - t1, 2)));
      sum += w * f.at(layer, i), weights += w;
    };
    add(below, site, 0), add(above, site, 0);
    for (int n = 0; with_b && l.space.bcc && n < 8; ++n) {
      Int3 i;
      for (size_t k = 0; k < 3; ++k) i[k] = site[k] + coset - 1 + (n >> k & 1);
      add(below + 1, i, 3 * plane * plane);
    }
    const int32_t nearer = t1 - below * distance < above * distance - t1 ? below : above;
    const double pitch = plane * (l.space.bcc ? 2 : 1);
    for (size_t k = 0; with_c && k < 3; ++k)
      for (const int step : {-1, 1}) {
        Int3 i = site;
        i[k] += step;
        add(nearer, i, pitch * pitch);
      }
    return sum / weights;
  };
}

// The 3D splat of section 4.2, divided by the sum of the weights.
double splat_gauss(const PaperField& f, const SliceValue& slice, const Vec3& p, double t1) {
  double sum = 0, weights = 0;
  for (int coset = 0; coset < f.lattice.space.cosets(); ++coset)
    near(f.lattice.space, coset, p, [&](const Int3& site, double r2) {
      sum += gauss(r2) * slice(coset, site, t1), weights += gauss(r2);
    });
  return sum / weights;
}

struct PaperLines {
  std::vector<Row> rows;
  size_t next = 0;
  void add(const std::string& name, const std::string& lattice, double rho, double db) {
    if (next == rows.size()) rows.push_back({word("pipeline", name), word("lattice", lattice)});
    rows[next++].push_back(figure("SNR dB, rho " + number(rho, 1), db, 1));
  }
};

void constant_sums(const Report& report) {
  // The sum of exp(-2 dt^2) over the layers of one coset at an instant, and of exp(-2 r^2) over 4D sites.
  std::vector<Row> rows;
  const auto layers = [](double from) {
    double sum = 0;
    for (int k = -2; k <= 2; ++k) {
      const double dt = k * std::numbers::sqrt2 + from;
      if (std::abs(dt) <= gauss_reach) sum += std::exp(-a * dt * dt);
    }
    return sum;
  };
  for (const double phase : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    const double t = phase / std::numbers::sqrt2; // between a layer of coset 0 and the next one, of coset 1
    rows.push_back({figure("phase", phase, 2), figure("coset 0", layers(t), 4),
                    figure("coset 1", layers(t - 1 / std::numbers::sqrt2), 4)});
  }
  report.table("Weights of the layers of each coset without division, exp(-2 dt^2)", rows);
  double neighbours = 24 * std::exp(-a * 2), rest = 0;
  for (int i = -2; i <= 2; ++i)
    for (int j = -2; j <= 2; ++j)
      for (int k = -2; k <= 2; ++k)
        for (int l = -2; l <= 2; ++l) {
          const double own = 2.0 * (i * i + j * j + k * k + l * l);
          const double other =
              2 * (std::pow(i + 0.5, 2) + std::pow(j + 0.5, 2) + std::pow(k + 0.5, 2) + std::pow(l + 0.5, 2));
          rest += gauss(own) + gauss(other);
        }
  report.table("Weight of the 24 nearest neighbours of a site of D4*",
               {{figure("share %", 100 * neighbours / rest, 1),
                 figure("each, of the centre's %", 100 * std::exp(-a * 2), 1)}});
}

} // namespace

void run_paper_kernel(const Report& report) {
  TestContext context;
  const uint32_t edge = report.quick ? 30 : 40;
  const size_t count = report.quick ? 100 : 600;
  constexpr std::array<double, 3> instants{0, 0.3, 0.5}; // in steps of two layers of D4*
  PaperLines lines;
  for (const double rho : wave_rhos) {
    lines.next = 0;
    const PlaneWaves waves(report.quick ? 60 : 300, rho, 17);
    for (const LatticeKind kind : {LatticeKind::d4star, LatticeKind::cc}) {
      const bool cc = kind == LatticeKind::cc;
      const PaperField field = sampled(waves, kind, edge);
      const Lattice4& lattice = field.lattice;
      const MemorySamples samples = memory_samples(field);
      const Vec3 unit = lattice.lattice_unit();
      const double frame_unit = lattice.time_step / lattice.layer_distance(); // frames per T
      const auto points = test::random_points(lattice, count, 19, wave_margin);
      const auto measure = [&](const std::string& name,
                               const std::function<double(const Vec3&, double)>& value) {
        double error = 0, signal = 0;
        for (const double phase : instants) {
          const double t1 = (lattice.layers() / 2 / 2 * 2 + 2 * phase) * lattice.layer_distance();
          for (const Vec4& p : points) {
            const double truth = waves({p[0], p[1], p[2], t1 * frame_unit});
            const double e = value({p[0] / unit[0], p[1] / unit[1], p[2] / unit[2]}, t1) - truth;
            signal += truth * truth;
            error += e * e;
          }
        }
        lines.add(name, cc ? "CC" : "D4*", rho, 10 * std::log10(signal / error));
      };
      const SliceValue by_layers = approximate(field), by_sites = accurate(field);
      const SliceValue exact = [&](int coset, const Int3& site, double t1) {
        const Vec3 p = lattice.site_position(coset, site);
        return waves({p[0], p[1], p[2], t1 * frame_unit});
      };
      measure("paper, approximate slice, splat",
              [&](const Vec3& p, double t) { return splat_gauss(field, by_layers, p, t); });
      // The slices themselves, at their sites: the error that splatting starts from.
      const auto at_sites = [&](const std::string& name, const SliceValue& slice) {
        double error = 0, signal = 0;
        for (const double phase : instants) {
          const double t1 = (lattice.layers() / 2 / 2 * 2 + 2 * phase) * lattice.layer_distance();
          const Int3 n = lattice.space.dims(0);
          for (int c = 0; c < lattice.space.cosets(); ++c)
            for (int z = n[2] / 4; z < 3 * n[2] / 4; z += 2)
              for (int y = n[1] / 4; y < 3 * n[1] / 4; y += 2)
                for (int x = n[0] / 4; x < 3 * n[0] / 4; x += 2) {
                  const Vec3 p = lattice.site_position(c, {x, y, z});
                  const double truth = waves({p[0], p[1], p[2], t1 * frame_unit});
                  signal += truth * truth, error += std::pow(slice(c, {x, y, z}, t1) - truth, 2);
                }
        }
        lines.add(name, cc ? "CC" : "D4*", rho, 10 * std::log10(signal / error));
      };
      const SliceValue of_a = by_neighbours(field, false, false), of_ab = by_neighbours(field, true, false),
                       of_abc = by_neighbours(field, true, true);
      at_sites("at sites, 2 A", of_a);
      at_sites("at sites, 2 A, 8 B", of_ab);
      at_sites("at sites, 2 A, 8 B, 6 C", of_abc);
      at_sites("at sites, own coset within 2 T", by_layers);
      at_sites("at sites, all within 2 T (equation 6)", by_sites);
      measure("paper, 2 A, splat", [&](const Vec3& p, double t) { return splat_gauss(field, of_a, p, t); });
      measure("paper, 2 A, 8 B, 6 C, splat",
              [&](const Vec3& p, double t) { return splat_gauss(field, of_abc, p, t); });
      measure("paper, accurate slice (equation 6), splat",
              [&](const Vec3& p, double t) { return splat_gauss(field, by_sites, p, t); });
      if (!report.quick)
        measure("exact slice, splat",
                [&](const Vec3& p, double t) { return splat_gauss(field, exact, p, t); });
      for (const char* kernel : {"paper", "default"}) {
        const Coefficients c(samples, 0, make_kernel(kernel), 0, 4ull << 30);
        std::function<double(const Vec3&, double)> value;
        double sliced_at = -1;
        Slice slice;
        measure(std::string("library, kernel ") + kernel, [&](const Vec3& p, double t) {
          if (t != sliced_at) slice = time_slice(c, t * frame_unit, {0, 0}, {}, context.get()), sliced_at = t;
          float v = 0;
          (void)evaluate(slice, std::span(&p, 1), std::span(&v, 1), {});
          return static_cast<double>(v);
        });
      }
    }
  }
  report.table("The paper's pipeline on 4D plane waves", lines.rows);
  constant_sums(report);
}

} // namespace bccsplat::bench
