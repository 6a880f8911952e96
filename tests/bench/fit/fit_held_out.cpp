// SPDX-License-Identifier: Apache-2.0
// Makes the frames that were left out again: by weights of those that are left (linear, Catmull-Rom, natural
// spline), by the library with ends mirrored or predicted, and by what `bcc4 import` makes of them. PSNR
// tells how near they are, steepness how sharp.
#include "tests/bench/fit/fit_held_out.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "field/coefficients/coefficients.h"
#include "field/evaluate.h"
#include "tests/bench/fit/fit_source.h"
#include "tests/bench/fit/tool_import.h"
#include "tests/bench/paper/paper.h"
#include "tests/bench/scale/scale_host.h"
#include "tests/support/fields.h"

namespace bccsplat::bench {
namespace {

using Frame = std::vector<float>;
// Weights of the frames 0 .. n-1 for the moment half-way between frames i and i + 1.
using Weights = std::function<std::vector<double>(size_t i, size_t n)>;

std::vector<double> linear(size_t i, size_t n) {
  std::vector<double> w(n);
  w[i] = w[i + 1] = 0.5;
  return w;
}

// Frames beyond the ends are continued straight.
std::vector<double> catmull_rom(size_t i, size_t n) {
  std::vector<double> w(n);
  const auto add = [&](int64_t at, double weight) {
    const auto last = static_cast<int64_t>(n) - 1;
    const int64_t end = std::clamp<int64_t>(at, 0, last);
    const int64_t inner = end == 0 ? 1 : last - 1;
    w[end] += at == end ? weight : 2 * weight;
    if (at != end) w[inner] -= weight;
  };
  const int64_t first = i;
  add(first - 1, -1.0 / 16), add(first, 9.0 / 16), add(first + 1, 9.0 / 16), add(first + 2, -1.0 / 16);
  return w;
}

// Half-way a cubic spline is the mean of its neighbours less an eighth of the mean of its second derivatives;
// these solve m[k-1] + 4 m[k] + m[k+1] = 6 (f[k-1] - 2 f[k] + f[k+1]), with none at the ends.
std::vector<double> natural_spline(size_t i, size_t n) {
  std::vector<double> w(n);
  for (size_t f = 0; f < n; ++f) {
    std::vector<double> diagonal(n, 4), m(n);
    for (size_t k = 1; k + 1 < n; ++k) m[k] = 6 * ((f == k - 1) - 2.0 * (f == k) + (f == k + 1));
    for (size_t k = 2; k + 1 < n; ++k) {
      diagonal[k] -= 1 / diagonal[k - 1];
      m[k] -= m[k - 1] / diagonal[k - 1];
    }
    for (size_t k = n - 2; k >= 1; --k) m[k] = (m[k] - (k + 2 < n ? m[k + 1] : 0)) / diagonal[k];
    w[f] = ((f == i) + (f == i + 1)) / 2.0 - (m[i] + m[i + 1]) / 16;
  }
  return w;
}

Frame blended(const std::vector<Frame>& kept, const std::vector<double>& weights) {
  std::vector<double> sum(kept[0].size());
  for (size_t f = 0; f < kept.size(); ++f)
    for (size_t k = 0; weights[f] != 0 && k < sum.size(); ++k) sum[k] += weights[f] * kept[f][k];
  return {sum.begin(), sum.end()};
}

// Sum of the squares of differences between neighbours along x and y.
double steepness(const Frame& f, const std::array<uint32_t, 4>& dims) {
  double sum = 0;
  const size_t nx = dims[0];
  for (size_t i = 0; i + nx < f.size(); ++i)
    sum += std::pow(static_cast<double>(f[i + 1] - f[i]), 2) +
           std::pow(static_cast<double>(f[i + nx] - f[i]), 2);
  return sum;
}

struct Score {
  double error = 0, edge_error = 0, steep = 0, true_steep = 0;
  size_t samples = 0, edge_samples = 0;
  std::vector<double> each; // errors by gap

  void add(const Frame& got, const Frame& truth, const std::array<uint32_t, 4>& dims, bool edge) {
    each.push_back(0);
    for (size_t k = 0; k < got.size(); ++k)
      each.back() += std::pow(static_cast<double>(got[k] - truth[k]), 2);
    (edge ? edge_error : error) += each.back();
    (edge ? edge_samples : samples) += got.size();
    steep += steepness(got, dims), true_steep += steepness(truth, dims);
  }
  [[nodiscard]] double sharpness() const { return std::sqrt(steep / true_steep); }
};

double psnr(double peak, double error, size_t samples) {
  return 10 * std::log10(peak * peak * static_cast<double>(samples) / error);
}

// The frames of a set that are left in, and those between them.
struct Halves {
  FitSource kept;
  std::vector<Frame> kept_frames, missing;
  double peak = 0;

  explicit Halves(const FitSource& s) : kept{s.name, s.dims, s.type, {}} {
    const uint32_t n = (s.dims[3] - 1) / 2; // missing ones, each between two that are not
    kept.dims[3] = n + 1;
    float low = INFINITY, high = -INFINITY;
    for (uint32_t t = 0; t <= 2 * n; ++t) {
      Frame frame = s.frame(t);
      const auto [l, h] = std::minmax_element(frame.begin(), frame.end());
      low = std::min(low, *l), high = std::max(high, *h);
      const auto bytes = s.bytes.begin() + (t * s.frame_bytes());
      if (t % 2 == 0) kept.bytes.insert(kept.bytes.end(), bytes, bytes + s.frame_bytes());
      (t % 2 == 0 ? kept_frames : missing).push_back(std::move(frame));
    }
    peak = high - low;
  }
  // Whether a gap is the first or the last one.
  [[nodiscard]] bool at_end(size_t gap) const { return gap == 0 || gap + 1 == missing.size(); }
};

// The field at the samples of a frame at time t, in frames.
using Field = std::function<Frame(std::span<const Vec4>)>;

Frame frame_at(const Field& field, const std::array<uint32_t, 4>& dims, double t) {
  std::vector<Vec4> points;
  for (uint32_t z = 0; z < dims[2]; ++z)
    for (uint32_t y = 0; y < dims[1]; ++y)
      for (uint32_t x = 0; x < dims[0]; ++x) points.push_back({1.0 * x, 1.0 * y, 1.0 * z, t});
  return field(points);
}

// How many dB a way loses to the best of the others where it loses most, and in which gap.
struct Behind {
  double db = -INFINITY;
  size_t gap = 0;
  Behind(const Score& score, const std::vector<double>& best) {
    for (size_t i = 0; i < best.size(); ++i)
      if (const double lost = 10 * std::log10(score.each[i] / best[i]); lost > db) db = lost, gap = i;
  }
};

// at: of the frames that were left in, without the first one; none for what goes through them. best: the
// least error of interpolation by gap.
Row row_of(const std::string& set, const std::string& way, const Score& between, const Score* at, double peak,
           const std::vector<double>& best) {
  const Behind behind(between, best);
  const bool inside = between.samples > 0;
  return {word("series", set),
          word("frames between", way),
          inside ? figure("PSNR dB", psnr(peak, between.error, between.samples), 2) : word("PSNR dB", "-"),
          figure("first and last gap", psnr(peak, between.edge_error, between.edge_samples), 2),
          figure("most behind the best", behind.db, 2),
          figure("in gap", static_cast<double>(behind.gap), 0),
          figure("sharpness", between.sharpness(), 3),
          at ? figure("PSNR at frames", psnr(peak, at->error, at->samples), 2)
             : word("PSNR at frames", "exact"),
          at ? figure("sharpness", at->sharpness(), 3) : word("sharpness", "1")};
}

// The row of a field, at the frames between and at those that were left in.
Row row_of(const Halves& halves, const std::vector<double>& best, const std::string& way,
           const Field& field) {
  const auto& dims = halves.kept.dims;
  Score between, at;
  for (size_t i = 0; i < halves.missing.size(); ++i) {
    between.add(frame_at(field, dims, static_cast<double>(i) + 0.5), halves.missing[i], dims,
                halves.at_end(i));
    if (i > 0) at.add(frame_at(field, dims, static_cast<double>(i)), halves.kept_frames[i], dims, false);
  }
  return row_of(halves.kept.name, way, between, &at, halves.peak, best);
}

// By the library: cubic D4*, layers beyond the ends mirrored or predicted.
void add_cubic(std::vector<Row>& rows, const Halves& halves, const std::vector<double>& best) {
  for (const int32_t lead : {0, 2, 4}) {
    FitOptions options;
    options.lead = lead;
    std::vector<std::vector<BrickLayer>> layers(1);
    const FitReport made = fit_source(halves.kept, options, 1, layers.data());
    const MemorySamples samples(made.lattice, {0}, std::move(layers));
    for (const char* kernel : {"default", "fine"}) {
      test::TestContext context;
      const Coefficients c(samples, 0, make_kernel(kernel), 0, 4ull << 30);
      const auto field = [&](std::span<const Vec4> points) {
        Frame values(points.size());
        (void)evaluate4(c, points, values, {}, context.get());
        return values;
      };
      rows.push_back(row_of(halves, best,
                            concat("D4*, ", kernel, ", ",
                                   lead == 0 ? std::string("mirrored") : concat(lead, " layers predicted")),
                            field));
    }
  }
}

// By what the tool makes of the frames that are left: unasked, and by ways to keep more of them.
void add_imported(std::vector<Row>& rows, const Halves& halves, const std::vector<double>& best) {
  const ToolImport tool(halves.kept);
  const Handle<bccsplat_device> device = make_api_device(1);
  for (const char* options : {"", "--ends predict", "--lattice cc", "--lattice cc --ends predict"}) {
    (void)tool.run(options);
    bccsplat_volume* opened = nullptr;
    api(bccsplat_volume_open_file(device.get(), tool.file().c_str(), nullptr, &opened));
    const Handle<bccsplat_volume> volume(opened);
    const auto field = [&](std::span<const Vec4> points) {
      Frame values(points.size());
      api(bccsplat_volume_evaluate(opened, points.size(), points.data()->data(), values.data(), nullptr));
      return values;
    };
    rows.push_back(row_of(halves, best, concat("bcc4 import ", options), field));
  }
}

void add_set(std::vector<Row>& rows, const FitSource& source) {
  const Halves halves(source);
  const auto& dims = halves.kept.dims;
  const std::pair<const char*, Weights> ways[] = {
      {"linear", linear}, {"Catmull-Rom", catmull_rom}, {"natural cubic spline", natural_spline}};
  std::vector<Score> interpolated;
  std::vector<double> best(halves.missing.size(), INFINITY);
  for (const auto& way : ways) {
    Score& score = interpolated.emplace_back();
    for (size_t i = 0; i < halves.missing.size(); ++i) {
      score.add(blended(halves.kept_frames, way.second(i, dims[3])), halves.missing[i], dims,
                halves.at_end(i));
      best[i] = std::min(best[i], score.each[i]);
    }
  }
  for (size_t i = 0; i < interpolated.size(); ++i)
    rows.push_back(row_of(source.name, ways[i].first, interpolated[i], nullptr, halves.peak, best));
  add_cubic(rows, halves, best);
  if (has_tool()) add_imported(rows, halves, best);
}

} // namespace

void report_held_out(const std::string& folder, const Report& report) {
  std::vector<Row> rows;
  for (const PaperSet& set : real_series())
    if (const auto source = load_paper_set(set, folder)) add_set(rows, *source);
  report.table(
      "every second frame left out: PSNR of these frames, and sharpness (steepness over the true one)", rows);
}

} // namespace bccsplat::bench
