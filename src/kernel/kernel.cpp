#include "kernel/kernel.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "base/error.h"
#include "kernel/radial.h"

namespace bccsplat {
namespace {

struct RadialEntry {
  std::string_view name;
  double radius;
  std::array<double, 6> a; // a_2 .. a_7
};

// Found by optimising the mean of the error figures over rho under a bound on the DC ripple.
constexpr RadialEntry radial_entries[] = {
    {"radial16", 1.6, {1.054805149, -5.712355171, 17.179981606, -25.936688971, 19.872364461, -5.988917206}},
    {"radial18", 1.8, {0.39237846, -2.007005707, 6.45913287, -9.910368855, 7.925313934, -2.447107359}},
    {"radial20", 2.0, {0.174490505, -0.8788769, 3.051135935, -4.610988913, 3.691225113, -1.07809601}},
    {"radial24", 2.4, {0.020647939, -0.015003387, 0.112124104, 0.090001233, -0.080791571, 0.131774297}},
};

struct Preset {
  std::string_view name, kernel;
};
constexpr Preset presets[] = {{"fast", "radial16+b2"}, {"default", "radial20+b3"}, {"fine", "radial24+b4"}};

RadialKernel radial(const RadialEntry& entry) {
  RadialKernel phi;
  phi.radius = entry.radius;
  phi.terms = 8;
  std::copy(entry.a.begin(), entry.a.end(), phi.a.begin() + 2);
  normalise_on_bcc(phi);
  return phi;
}

TemporalKernel spline(int order) {
  TemporalKernel beta;
  beta.order = order;
  beta.half_width = order * std::numbers::sqrt2 / 2;
  return beta;
}

TemporalKernel gaussian_layers(double g, double half_width) {
  TemporalKernel beta;
  beta.shape = TemporalKernel::Shape::gaussian;
  beta.gaussian = g;
  beta.half_width = half_width;
  beta.scale =
      std::numbers::sqrt2 / beta.integral(-half_width, half_width); // layers of a coset are sqrt2 apart
  return beta;
}

double variance(const TemporalKernel& beta) {
  return beta.shape == TemporalKernel::Shape::bspline ? beta.order / 6.0 : 0.5 / beta.gaussian;
}

// n equal stages whose product has the inverse second moments of the kernel: exact for fields up to third
// degree.
void match_moments(Kernel& kernel, int n) {
  const double vs = radial_variance(kernel.space);
  const double vt = variance(kernel.time);
  PrefilterStage s4;
  s4.cross = -0.08 * std::min(vs, vt) / n;
  s4.spatial = -0.25 * vs / n - 2 * s4.cross;
  s4.temporal = -0.25 * vt / n - 2 * s4.cross;
  s4.self = 1 - 6 * s4.spatial - 2 * s4.temporal - 16 * s4.cross;
  PrefilterStage s3;
  s3.cross = -0.15 * vs / n;
  s3.spatial = -0.25 * vs / n - s3.cross;
  s3.self = 1 - 6 * s3.spatial - 8 * s3.cross;
  kernel.prefilter4.assign(static_cast<size_t>(n), s4);
  kernel.prefilter3.assign(static_cast<size_t>(n), s3);
  const double bound =
      std::abs(s4.self) + 6 * std::abs(s4.spatial) + 2 * std::abs(s4.temporal) + 16 * std::abs(s4.cross);
  kernel.prefilter_gain = std::pow(bound, n);
}

size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t{0});
  for (size_t i = 0; i < a.size(); ++i) {
    size_t diagonal = std::exchange(row[0], i + 1);
    for (size_t j = 0; j < b.size(); ++j) {
      const size_t change = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({change, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

[[noreturn]] void unknown_name(std::string_view name) {
  const std::vector<std::string> names = kernel_names();
  const auto nearest = std::min_element(names.begin(), names.end(), [&](const auto& a, const auto& b) {
    return edit_distance(name, a) < edit_distance(name, b);
  });
  fail(Code::not_found, "unknown kernel '", name, "'; did you mean '", *nearest,
       "'? Kernels are fast, default, fine, paper, gauss09 or SPACE+TIME with SPACE radial16, radial18, "
       "radial20 or "
       "radial24 and TIME b2, b3 or b4");
}

} // namespace

Reach prefilter_reach(std::span<const PrefilterStage> stages) {
  Reach reach;
  for (const PrefilterStage& s : stages) {
    const int cross = s.cross != 0 ? 1 : 0;
    const int space = s.spatial != 0 || s.mixed != 0 ? 2 : cross;
    const int time = s.temporal != 0 || s.mixed != 0 ? 2 : cross;
    reach.space = std::max(reach.space + space, s.source_spatial != 0 || s.source_mixed != 0 ? 2 : 0);
    reach.time = std::max(reach.time + time, s.source_temporal != 0 || s.source_mixed != 0 ? 2 : 0);
  }
  return reach;
}

int Kernel::reach_layers() const {
  // Layers are 1/sqrt2 apart; the tolerance keeps a half width of a whole number of layers whole.
  const int support = static_cast<int>(std::ceil(time.half_width * std::numbers::sqrt2 - 1e-9));
  return support + prefilter_reach(prefilter4).time;
}

std::vector<std::string> kernel_names() {
  std::vector<std::string> names;
  for (const Preset& preset : presets) names.emplace_back(preset.name);
  names.emplace_back("paper");
  names.emplace_back("gauss09");
  for (const RadialEntry& entry : radial_entries)
    for (const char* time : {"+b2", "+b3", "+b4"}) names.push_back(std::string(entry.name) + time);
  return names;
}

Kernel make_kernel(std::string_view name) {
  if (name.empty()) name = "default";
  for (const Preset& preset : presets)
    if (name == preset.name) name = preset.kernel;

  Kernel kernel;
  kernel.name = name;
  if (name == "paper") {
    kernel.space = gaussian_kernel(2, 2);
    kernel.time = gaussian_layers(2, 2);
    kernel.normalised = true;
    return kernel;
  }
  if (name == "gauss09") {
    constexpr double cut = 2 * std::numbers::sqrt2; // four layers of each coset
    kernel.space = gaussian_kernel(0.9, cut);
    kernel.time = gaussian_layers(0.9, cut);
    match_moments(kernel, 4);
    return kernel;
  }
  for (const RadialEntry& entry : radial_entries) {
    for (int order = 2; order <= 4; ++order) {
      if (name != concat(entry.name, "+b", order)) continue;
      kernel.space = radial(entry);
      kernel.time = spline(order);
      match_moments(kernel, entry.radius > 2 ? 4 : 3);
      return kernel;
    }
  }
  unknown_name(name);
}

double lattice_sum(const Kernel& kernel, double x, double y, double z) {
  if (!kernel.normalised) return 1;
  // Poisson: the sum relative to its mean is sum_k exp(-pi^2 |k|^2 / g) cos(2 pi k.x) over the dual lattice,
  // 12 vectors
  // (+-1, +-1, 0) / sqrt2 and 6 vectors sqrt2 (+-1, 0, 0) being enough for the paper's Gaussian.
  constexpr double pi = std::numbers::pi;
  const double first = std::exp(-pi * pi / kernel.time.gaussian);
  const double cx = std::cos(std::numbers::sqrt2 * pi * x);
  const double cy = std::cos(std::numbers::sqrt2 * pi * y);
  const double cz = std::cos(std::numbers::sqrt2 * pi * z);
  const double second = first * first;
  return 1 + 4 * first * (cx * cy + cy * cz + cz * cx) + 2 * second * (2 * (cx * cx + cy * cy + cz * cz) - 3);
}

} // namespace bccsplat
