// SPDX-License-Identifier: Apache-2.0
// The methods of Neophytou & Mueller 2002, section 4, beside ours.
#include <algorithm>
#include <cmath>

#include "field/evaluate.h"
#include "field/sample_grid.h"
#include "formats/bcc4/read/reader.h"
#include "formats/bcc4/read/samples.h"
#include "slice/extraction.h"
#include "slice/time_slice.h"
#include "tests/bench/fit/fit_fields.h"
#include "tests/bench/slice/slice_parts.h"
#include "tests/bench/storage/storage_series.h"

namespace bccsplat::bench {
namespace {

using test::TestContext;

struct Method {
  const char* name;
  const char* kernel;
  SliceMethod method;
};
const Method methods[] = {{"ours, merged", "default", SliceMethod::merged},
                          {"ours, resampled", "default", SliceMethod::resampled},
                          {"paper's kernel, merged", "paper", SliceMethod::merged},
                          {"paper's interpolation, eq. (6)", "paper", SliceMethod::resampled}};

// Points whose value matters, counted in a slice.
struct Counts {
  double relevant = 0;     // the paper's rule: interpolated values that are not air
  double coefficients = 0; // points that our slice keeps
};
Counts count_points(const SampleSource& source, float prune, double frame, const Context& context) {
  // The weights of the paper's kernel are positive and nothing is filtered: a site of the slice is kept where
  // a sample in reach in time is.
  const Coefficients plain(source, 0, make_kernel("paper"), 0, large_cache);
  const Coefficients ours(source, 0, make_kernel("default"), prune, large_cache);
  return {static_cast<double>(time_slice(plain, frame, {0, 0}, {}, context).points()),
          static_cast<double>(time_slice(ours, frame, {0, 0}, {}, context).points())};
}

Row counts_row(const std::string& name, const SampleSource& bcc, const SampleSource& cc, float prune,
               const Context& context) {
  Counts a, b;
  const double last = bcc.lattice().last_frame();
  constexpr int slices = 5; // at times that are no frames
  for (int i = 0; i < slices; ++i) {
    const double frame = std::floor(last * (i + 0.5) / slices) + 0.37;
    const Counts x = count_points(bcc, prune, std::min(frame, last), context),
                 y = count_points(cc, prune, std::min(frame, last), context);
    a.relevant += x.relevant / slices, a.coefficients += x.coefficients / slices;
    b.relevant += y.relevant / slices, b.coefficients += y.coefficients / slices;
  }
  const auto percent = [](double part, double whole) { return whole > 0 ? 100 * part / whole : 0; };
  return {word("series", name),
          figure("CC relevant", b.relevant, 0),
          figure("D4* relevant", a.relevant, 0),
          figure("D4* / CC %", percent(a.relevant, b.relevant), 1),
          figure("CC coefficients", b.coefficients, 0),
          figure("D4* coefficients", a.coefficients, 0),
          figure("coefficients D4* / CC %", percent(a.coefficients, b.coefficients), 1)};
}

constexpr const char* counts_title = "Points of a time slice, mean of 5 instants between frames";

} // namespace

std::vector<NamedPlane> planes_through_centre(const std::array<uint32_t, 4>& dims) {
  const auto through = [&](const char* name, const Vec4& n) {
    double e = 0;
    for (size_t i = 0; i < 4; ++i) e -= n[i] * ((dims[i] - 1.0) / 2 + 0.21);
    return NamedPlane{name, {n[0], n[1], n[2], n[3], e}};
  };
  return {through("t = const", {0, 0, 0, 1}), through("x = const", {1, 0, 0, 0}),
          through("oblique in x, t", {1, 0, 0, 1}), through("oblique", {1, -0.7, 0.4, 0.8})};
}

double Balls::operator()(const Vec4& p) const {
  double sum = 0;
  for (int i = 0; i < 8; ++i) {
    const double turn = 6.2831853 * (i / 8.0 + (1 + i % 3) * p[3] / (4.0 * dims[3]));
    const double swell = radius * (0.6 + 0.05 * i) / 2;
    const double x = p[0] - dims[0] * (0.5 + 0.3 * std::cos(turn)),
                 y = p[1] - dims[1] * (0.5 + 0.3 * std::sin(turn)), z = p[2] - dims[2] * (0.3 + 0.05 * i);
    sum += std::exp(-(x * x + y * y + z * z) / (2 * swell * swell));
  }
  return sum < 1e-3 ? 0 : sum;
}

SlicePoints slice_points(const Slice& slice, const std::array<uint32_t, 4>& dims, double margin,
                         size_t count) {
  std::mt19937 random(5);
  SlicePoints points;
  for (int tries = 0; tries < 400000 && points.uvw.size() < count; ++tries) {
    Vec3 p;
    for (size_t a = 0; a < 3; ++a)
      p[a] = std::uniform_real_distribution<double>(0, slice.domain_end[a])(random);
    p = slice.lattice_to_slice.point(p);
    Vec4 q = slice.origin;
    bool inside = true;
    for (size_t i = 0; i < 4; ++i) {
      for (size_t k = 0; k < 3; ++k) q[i] += p[k] * slice.basis[k][i];
      inside = inside && q[i] >= margin && q[i] <= dims[i] - 1.0 - margin;
    }
    if (inside) points.uvw.push_back(p), points.index.push_back(q);
  }
  return points;
}

double snr(std::span<const float> values, std::span<const Vec4> points, const test::Field4& f) {
  double signal = 0, error = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    const double truth = f(points[i]);
    signal += truth * truth, error += std::pow(values[i] - truth, 2);
  }
  return 10 * std::log10(signal / error);
}

double slice_snr(const Slice& slice, const std::array<uint32_t, 4>& dims, const test::Field4& f,
                 double margin, const Context& context) {
  const SlicePoints points = slice_points(slice, dims, margin, 2000);
  std::vector<float> values(points.uvw.size());
  sample_points(slice, points.uvw, values, {}, context);
  return snr(values, points.index, f);
}

void report_paper_methods(const Report& report) {
  TestContext context(1);
  const uint32_t n = report.quick ? 24 : 32;
  const std::array<uint32_t, 4> dims{n, n, n, n};
  std::vector<Row> rows;
  const auto lattice = Lattice4::fit(LatticeKind::d4star, dims);
  for (const double rho : report.quick ? std::vector<double>{0.5} : std::vector<double>{0.3, 0.5, 0.7}) {
    const test::PlaneWaves waves(10, rho, 3);
    const MemorySamples samples = test::sample_field(lattice, waves);
    for (const NamedPlane& p : planes_through_centre(dims)) {
      if (p.name == "oblique in x, t") continue;
      SlicePoints points;
      std::vector<float> values;
      const auto add = [&](const char* method, double made, double sampled, uint64_t count) {
        rows.push_back(
            {figure("rho", rho, 1), word("slice", p.name), word("method", method),
             figure("SNR dB", snr(values, points.index, waves), 1),
             figure("points", static_cast<double>(count), 0), figure("slice ms", 1000 * made, 1),
             figure("us per 1000 samples", 1e9 * sampled / static_cast<double>(values.size()), 0)});
      };
      for (const Method& m : methods) {
        HypersliceOptions options;
        options.method = m.method;
        const bool mergeable = p.name != "oblique";
        if (m.method == SliceMethod::merged && !mergeable) continue;
        // Coefficients count: what a slice costs from the samples.
        const Coefficients coefficients(samples, 0, make_kernel(m.kernel), 0, large_cache);
        Slice slice;
        const double made =
            cpu_seconds([&] { slice = hyperslice(coefficients, p.h, options, {}, context.get()); });
        points = slice_points(slice, dims, 7, 4000);
        values.resize(points.uvw.size());
        const double sampled =
            cpu_seconds([&] { sample_points(slice, points.uvw, values, {}, context.get()); });
        add(m.name, made, sampled, slice.points());
      }
      std::unique_ptr<const Extraction> extraction;
      const double made = cpu_seconds([&] {
        extraction = std::make_unique<const Extraction>(samples, 0, p.h, plane_axes(p.h), context.get());
      });
      const double sampled = cpu_seconds([&] { extraction->sample(points.uvw, values, {}, context.get()); });
      add("paper's extraction", made, sampled, extraction->points());
    }
  }
  report.table(concat("The paper's methods and ours: slices of ", n, "^4 plane waves, from the samples"),
               rows);
}

void report_relevant_points(const Report& report) {
  TestContext context(1);
  const uint32_t n = report.quick ? 28 : 64;
  std::vector<Row> rows;
  const std::array<uint32_t, 4> dims{n, n, n, 16};
  for (const auto& [name, part] : {std::pair{"balls, small", 0.06}, {"balls, large", 0.15}}) {
    const Balls balls{dims, part * n};
    const MemorySamples bcc = test::sample_field(Lattice4::fit(LatticeKind::d4star, dims), balls);
    const MemorySamples cc = test::sample_field(Lattice4::fit(LatticeKind::cc, dims), balls);
    rows.push_back(counts_row(name, bcc, cc, 5e-4f, context.get()));
  }
  const FitSeries smoke = smoke_like(dims);
  Quantiser quantiser;
  quantiser.air = 0;
  const StoredSeries a = store(smoke, {.quantiser = quantiser, .level = 1});
  const StoredSeries b = store(smoke, {.lattice = LatticeKind::cc, .quantiser = quantiser, .level = 1});
  const Bcc4Samples bcc(Bcc4Reader::open(open_memory_source(a.file)), context.memory);
  const Bcc4Samples cc(Bcc4Reader::open(open_memory_source(b.file)), context.memory);
  rows.push_back(counts_row("smoke, fitted", bcc, cc, 5e-4f, context.get()));
  report.table(counts_title, rows);
}

void report_relevant_points(const Report& report, const std::string& d4star_file,
                            const std::string& cc_file) {
  TestContext context(2);
  const auto bcc_reader = Bcc4Reader::open(open_file_source(d4star_file)),
             cc_reader = Bcc4Reader::open(open_file_source(cc_file));
  const Bcc4Samples bcc(bcc_reader, context.memory), cc(cc_reader, context.memory);
  report.table(counts_title, {counts_row(d4star_file, bcc, cc, bcc_reader->info().channels[0].threshold / 2,
                                         context.get())});
}

} // namespace bccsplat::bench
