// SPDX-License-Identifier: Apache-2.0
// Evaluates sets of points, as hosts ask for them, one by one, in a slice and as the renderer does, in turn
// with the quadricubic spline; errors are those of plane waves at random points.
#include "tests/bench/evaluate/evaluate.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "base/error.h"
#include "base/text.h"
#include "field/coefficients/coefficients.h"
#include "field/evaluate.h"
#include "field/sample_grid.h"
#include "shade/surface.h"
#include "slice/time_slice.h"
#include "tests/bench/kernels/kernels_cartesian_field.h"
#include "tests/support/band_limited.h"
#include "tests/support/dense_layer.h"
#include "tests/support/fields.h"

namespace bccsplat::bench {
namespace {

using test::PlaneWaves;

constexpr double margin =
    8; // of the points from the ends of the domain: waves are not their own mirror images
constexpr double rho = 0.7;
constexpr const char* kernels[] = {"paper", "fast", "default", "fine", "gauss09"};

struct Points {
  const char* name;
  std::vector<Vec4> at;
  size_t edge = 0; // of a cubic grid at one instant
  double spacing = 0;
};

// What hosts ask for: the samples of a grid at one instant; paths through space and time, finely and coarsely
// sampled; what the pixels of a picture see of a surface; and anything.
std::vector<Points> point_sets(const std::array<uint32_t, 4>& dims, size_t count) {
  std::vector<Points> sets{{"grid", {}}, {"paths", {}}, {"strides", {}}, {"surface", {}}, {"random", {}}};
  std::mt19937 random(31);
  const auto anywhere = [&] {
    Vec4 p;
    for (size_t a = 0; a < 4; ++a)
      p[a] = std::uniform_real_distribution<double>(std::min(margin, 0.4 * dims[a]),
                                                    dims[a] - 1 - std::min(margin, 0.4 * dims[a]))(random);
    return p;
  };
  const auto edge = static_cast<size_t>(std::cbrt(static_cast<double>(count)));
  const double step = (dims[0] - 1 - 2 * margin) / static_cast<double>(edge);
  sets[0].edge = edge, sets[0].spacing = step;
  for (size_t z = 0; z < edge; ++z)
    for (size_t y = 0; y < edge; ++y)
      for (size_t x = 0; x < edge; ++x)
        sets[0].at.push_back({margin + step * static_cast<double>(x), margin + step * static_cast<double>(y),
                              margin + step * static_cast<double>(z), 0.5 * dims[3] + 0.37});
  // Each step goes `stride` T through space and `duration` frames through time.
  const auto add_paths = [&](Points& to, size_t length, double stride, double duration) {
    while (to.at.size() + length <= count) {
      const Vec4 from = anywhere();
      Vec4 direction = anywhere();
      double norm = 0;
      for (size_t a = 0; a < 3; ++a) direction[a] -= 0.5 * dims[a], norm += direction[a] * direction[a];
      for (size_t i = 0; i < length; ++i) {
        Vec4 p = from;
        for (size_t a = 0; a < 3; ++a)
          p[a] += stride * static_cast<double>(i) * direction[a] / std::sqrt(norm);
        p[3] = 0.5 * dims[3] + duration * static_cast<double>(i);
        to.at.push_back(p);
      }
    }
  };
  add_paths(sets[1], 256, 0.02, 0.005);
  add_paths(sets[2], 16, 0.3, 0.05);
  // Tiles of 8 x 8 pixels 0.4 T apart, the depth of a sloping surface.
  constexpr size_t tile = 8;
  const auto across = static_cast<size_t>((dims[0] - 1 - 2 * margin) / (0.4 * tile));
  for (size_t n = 0; sets[3].at.size() + tile * tile <= count; ++n)
    for (size_t i = 0; i < tile * tile; ++i) {
      const double x = 0.4 * static_cast<double>(n % across * tile + i % tile);
      const double y = 0.4 * static_cast<double>(n / across % across * tile + i / tile);
      const double z = 0.5 * dims[2] + 0.2 * (dims[2] - 2 * margin) * std::sin(0.1 * x + 0.07 * y);
      sets[3].at.push_back({margin + x, margin + y, z, 0.5 * dims[3] + 0.37});
    }
  while (sets.back().at.size() < count) sets.back().at.push_back(anywhere());
  return sets;
}

double nanoseconds(double seconds, size_t points) { return seconds * 1e9 / static_cast<double>(points); }

// Of values (and gradients in space) at random points, in dB.
struct Error {
  double value = 0, gradient = 0;
};

Error error_of(const PlaneWaves& field, const std::vector<Vec4>& points, std::span<const float> values,
               std::span<const std::array<float, 4>> gradients) {
  double signal = 0, miss = 0, steep = 0, steep_miss = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    const double f = field(points[i]), e = values[i] - f;
    signal += f * f, miss += e * e;
    const Vec4 g = field.gradient(points[i]);
    for (size_t a = 0; a < 3; ++a) {
      const double d = gradients[i][a] - g[a];
      steep += g[a] * g[a], steep_miss += d * d;
    }
  }
  return {10 * std::log10(signal / miss), 10 * std::log10(steep / steep_miss)};
}

} // namespace

int run_evaluate_suite(std::span<const std::string> args, const Report& report) {
  int threads = 1;
  std::string only_kernel, only_points;
  for (size_t i = 0; i < args.size(); i += 2) {
    const std::string value = i + 1 < args.size() ? args[i + 1] : "";
    const bool known = args[i] == "--threads" || args[i] == "--kernel" || args[i] == "--points";
    if (!known || value.empty())
      fail(Code::invalid_argument, "evaluate: options are --threads N, --kernel NAME, --points NAME");
    if (args[i] == "--kernel") only_kernel = value;
    if (args[i] == "--points") only_points = value;
    if (args[i] != "--threads") continue;
    threads = parse_number<int>(value).value_or(0);
    if (threads < 1) fail(Code::invalid_argument, "evaluate: --threads wants a whole number, at least 1");
  }
  Tasks tasks(threads);
  MemoryBudget memory;
  Progress progress;
  const Context context{tasks, memory, progress};
  const std::array<uint32_t, 4> dims =
      report.quick ? std::array<uint32_t, 4>{40, 40, 40, 20} : std::array<uint32_t, 4>{96, 96, 96, 24};
  const size_t count = report.quick ? 20'000 : 1'000'000;
  const int repeats = report.quick ? 1 : 5;
  const std::vector<Points> sets = point_sets(dims, count);
  const std::vector<Vec4> probe(sets.back().at.begin(), sets.back().at.begin() + (report.quick ? 500 : 4000));

  const PlaneWaves field(40, rho, 5);
  test::Grid4 grid;
  for (size_t a = 0; a < 4; ++a)
    for (uint32_t i = 0; i < dims[a]; ++i) grid[a].push_back(i);
  Quadricubic cubic{dims, {}};
  {
    const CartesianField prefiltered(dims, field.on_grid(grid), CartesianKernel::cubic_interpolating);
    cubic.coefficients.assign(prefiltered.coefficients().begin(), prefiltered.coefficients().end());
  }
  const auto lattice = Lattice4::fit(LatticeKind::d4star, dims);
  std::vector<std::vector<BrickLayer>> layers(1);
  for (int32_t m = 0; m < lattice.layers(); ++m) {
    const std::vector<double> v = field.on_grid(test::layer_grid(lattice, m));
    layers[0].push_back(
        test::layer_from_dense(lattice.space, lattice.coset(m), std::vector<float>(v.begin(), v.end())));
  }
  const MemorySamples samples(lattice, {0}, std::move(layers));

  std::vector<float> values(count), reference(count);
  std::vector<std::array<float, 4>> gradients(count), reference_gradients(count);
  // The baseline runs on one thread; its time per point is that of one core, like the others' CPU time.
  const auto baseline = [&](const std::vector<Vec4>& points, bool slopes) {
    evaluate_quadricubic(cubic, points, reference.data(), slopes ? reference_gradients.data() : nullptr);
  };
  std::vector<Row> rows, times;
  Plot plot{.title = "Error against time per point: random plane waves, rho " + number(rho, 1) +
                     ", grid at one instant",
            .x_label = "CPU ns per point",
            .y_label = "signal to error, dB",
            .log_x = true,
            .series = {}};
  evaluate_quadricubic(cubic, probe, reference.data(), reference_gradients.data());
  const Error cubic_error =
      error_of(field, probe, std::span(reference).first(probe.size()),
               std::span<const std::array<float, 4>>(reference_gradients).first(probe.size()));
  std::vector<double> cubic_times;
  for (const char* name : kernels) {
    if (!only_kernel.empty() && only_kernel != name) continue;
    const Coefficients c(samples, 0, make_kernel(name), 0, 8ull << 30);
    (void)evaluate4(c, probe, std::span(values).first(probe.size()), std::span(gradients).first(probe.size()),
                    context);
    const Error error = error_of(field, probe, std::span(values).first(probe.size()),
                                 std::span<const std::array<float, 4>>(gradients).first(probe.size()));
    enum class Way { points, slice_grid, slice, renderer };
    constexpr const char* ways[] = {"", ", as a slice", ", in a slice", ", in a slice, by the renderer"};
    struct Case {
      const Points& set;
      bool slopes;
      Way way;
    };
    std::vector<Case> cases{{sets[0], false, Way::slice_grid}};
    for (const Points& set : sets)
      for (const bool slopes : {false, true}) cases.push_back({set, slopes, Way::points});
    cases.push_back({sets[3], false, Way::slice});
    cases.push_back({sets[3], true, Way::slice});
    cases.push_back({sets[3], true, Way::renderer});
    const Slice instant = time_slice(c, sets[3].at[0][3], {0, 0}, {}, context);
    const Affine3 to_lattice = instant.lattice_to_slice.inverse();
    std::vector<Vec3> places, steep(sets[3].at.size());
    for (const Vec4& p : sets[3].at) places.push_back(to_lattice.point({p[0], p[1], p[2]}));
    std::vector<std::array<float, 3>> slice_gradients(places.size());
    for (const auto& [set, slopes, way] : cases) {
      if (!only_points.empty() && only_points != set.name) continue;
      const size_t n = set.at.size();
      const auto body = [&] {
        if (way == Way::slice) {
          (void)evaluate(instant, places, std::span(values).first(n),
                         slopes ? std::span(slice_gradients) : std::span<std::array<float, 3>>());
          return;
        }
        if (way == Way::renderer) {
          field_at(SurfaceField(instant), places, std::span(values).first(n), steep);
          return;
        }
        if (way == Way::slice_grid) {
          const Slice slice = time_slice(c, set.at[0][3], {0, 0}, {}, context);
          const auto e = static_cast<int32_t>(set.edge);
          sample_grid(slice,
                      {{set.at[0][0], set.at[0][1], set.at[0][2]},
                       {set.spacing, set.spacing, set.spacing},
                       {e, e, e}},
                      values.data(), context);
          return;
        }
        (void)evaluate4(c, set.at, std::span(values).first(n),
                        slopes ? std::span(gradients).first(n) : std::span<std::array<float, 4>>(), context);
      };
      body(); // layers are made on first use
      const auto [ours, theirs] = paired_cpu_seconds(
          body, [&] { baseline(set.at, slopes); }, repeats);
      rows.push_back({word("kernel", name), word("points", concat(set.name, ways[static_cast<size_t>(way)])),
                      word("result", slopes ? "value and gradient" : "value"),
                      figure("ns per point", nanoseconds(ours, n), 1),
                      figure("Mpoints/s/core", static_cast<double>(n) / ours / 1e6, 1),
                      figure("quadricubic ns", nanoseconds(theirs, n), 1),
                      figure("time ratio", ours / theirs, 2),
                      figure("SNR dB", slopes ? error.gradient : error.value, 1),
                      figure("quadricubic SNR dB", slopes ? cubic_error.gradient : cubic_error.value, 1)});
      if (&set == &sets[0] && !slopes) {
        const bool sliced = way == Way::slice_grid;
        plot.series.push_back(
            {.title = std::string("D4* ") + name + (sliced ? ", as a slice" : ", point by point"),
             .points = {{nanoseconds(ours, n), error.value}},
             .line = false,
             .labels = {sliced ? concat(name, ", slice") : name}});
        cubic_times.push_back(nanoseconds(theirs, n));
      }
    }
  }
  report.table("Evaluation of one million points; CPU time", rows);
  if (rows.empty()) fail(Code::invalid_argument, "evaluate: no such kernel or set of points");
  if (cubic_times.empty()) return 0; // no grid, no plot
  std::sort(cubic_times.begin(), cubic_times.end());
  plot.series.push_back({.title = "CC quadricubic B-spline, interpolating (all samples)",
                         .points = {{cubic_times[cubic_times.size() / 2], cubic_error.value}},
                         .line = false,
                         .labels = {"quadricubic"}});
  report.plot("error-time", plot);
  return 0;
}

} // namespace bccsplat::bench
