// SPDX-License-Identifier: Apache-2.0
// The kernels that files and hosts name, in three tables below. A new kernel needs
//   a line in radial_entries and one in bend_entries for a new shape, or one in presets for a short name of
//   such a pair
//     (what is no radial polynomial times a spline gets a branch in make_kernel, as gauss09 has);
//   its stages on D4* and BCC and a line of `entries` in prefilter_tables.inc, and up to a radius of 2 T a
//     line in cc_tables.inc (until they are designed those of a neighbour will do);
//   its name above make_kernel in kernel.h, in unknown_name() and in the list of src/api/library.cpp.
// tests/bench/notes/kernels.md says what the numbers optimise, what was tried, and where the programs are
// that designed them. tests/unit/kernel covers it: names_test counts the names, accuracy_test holds each to
// the dB that its line there states, radial_test and temporal_test look at shapes and bends.
#include "kernel/kernel.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "base/error.h"
#include "base/text.h"
#include "kernel/prefilter_tables.h"
#include "kernel/radial.h"

namespace bccsplat {
namespace {

struct RadialEntry {
  std::string_view name;
  double radius;
  std::array<double, 6> a; // a_2 .. a_7
};

// Shapes, made by `bccsplat_bench kernels --shape NAME`: those of least error over the band and at 0 with the
// best prefilter, phi being monotone (radial18 is the set it could not beat).
constexpr RadialEntry radial_entries[] = {
    {"radial16", 1.6, {0.712486763, -3.75225702, 12.1204175, -18.2852967, 13.3827716, -3.66374063}},
    {"radial18", 1.8, {0.39237846, -2.007005707, 6.45913287, -9.910368855, 7.925313934, -2.447107359}},
    {"radial20", 2.0, {0.189979217, -0.960719889, 3.26797299, -4.93424306, 3.9492547, -1.16961136}},
    {"radial24", 2.4, {0.0246464229, -0.048707812, 0.232477255, -0.118333418, 0.0927300279, 0.0749821557}},
};

// Bends of the temporal splines b2, b3, b4, made by `bccsplat_bench kernels --bend all`: those of least error
// over the band, with the phases of larger error counting more. Hats stay straight: with one layer of a coset
// at some phases and two at others no weights make these alike, and what the worst phases gain the mean
// loses.
struct BendEntry {
  std::string_view space;
  std::array<std::array<double, 2>, 3> bend;
};
constexpr BendEntry bend_entries[] = {
    {"radial16", {{{0, 0}, {0.150145, -0.006448}, {0.008436, 0.012115}}}},
    {"radial18", {{{0, 0}, {0.119353, -0.003226}, {0.004973, 0.005777}}}},
    {"radial20", {{{0, 0}, {0.102437, -0.002779}, {0.002457, 0.002704}}}},
    {"radial24", {{{0, 0}, {0.073188, -0.001994}, {0.002049, 0.002480}}}},
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

TemporalKernel spline(std::string_view space, int order) {
  TemporalKernel beta;
  for (const BendEntry& entry : bend_entries)
    if (entry.space == space) beta.bend = entry.bend[static_cast<size_t>(order) - 2];
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

void set_prefilters(Kernel& kernel) {
  const PrefilterTable table = shipped_prefilters(kernel.name);
  kernel.prefilter4 = table.stages4;
  kernel.prefilter3 = table.stages3;
  kernel.prefilter_gain = table.gain;
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
  // Where most letters differ something else was meant.
  const bool alike = 2 * edit_distance(name, *nearest) <= std::max(name.size(), nearest->size());
  fail(Code::not_found, "unknown kernel '", name, alike ? concat("'; did you mean '", *nearest, "'?") : "'.",
       " Kernels are fast, default, fine, exact, paper, gauss09 or SPACE+TIME with SPACE radial16, radial18, "
       "radial20 or radial24 and TIME b2, b3 or b4");
}

} // namespace

Reach prefilter_reach(std::span<const PrefilterStage> stages) {
  Reach reach;
  for (const PrefilterStage& s : stages) {
    const int cross = s.cross != 0 ? 1 : 0;
    const int space = s.spatial != 0 || s.mixed != 0 ? 2 : cross;
    const int time = s.temporal != 0 || s.mixed != 0 ? 2 * s.stride : cross;
    const int pole = s.pole != 0 ? PrefilterStage::pole_reach : 0;
    reach.space = std::max(reach.space + space + pole, s.source_spatial != 0 || s.source_mixed != 0 ? 2 : 0);
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
  names.emplace_back("exact");
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
  if (name == "exact") {
    kernel = make_kernel("default");
    kernel.name = name;
    return kernel;
  }
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
    set_prefilters(kernel);
    return kernel;
  }
  for (const RadialEntry& entry : radial_entries) {
    for (int order = 2; order <= 4; ++order) {
      if (name != concat(entry.name, "+b", order)) continue;
      kernel.space = radial(entry);
      kernel.time = spline(entry.name, order);
      set_prefilters(kernel);
      return kernel;
    }
  }
  unknown_name(name);
}

double lattice_sum(const Kernel& kernel, double x, double y, double z) {
  if (!kernel.normalised) return 1;
  // By Poisson's formula the sum relative to its mean is sum_k exp(-pi^2 |k|^2 / g) cos(2 pi k.x) over the
  // dual lattice, 12 vectors (+-1, +-1, 0) / sqrt2 and 6 vectors sqrt2 (+-1, 0, 0) being enough for the
  // paper's Gaussian.
  constexpr double pi = std::numbers::pi;
  const double first = std::exp(-pi * pi / kernel.time.gaussian);
  const double cx = std::cos(std::numbers::sqrt2 * pi * x);
  const double cy = std::cos(std::numbers::sqrt2 * pi * y);
  const double cz = std::cos(std::numbers::sqrt2 * pi * z);
  const double second = first * first;
  return 1 + 4 * first * (cx * cy + cy * cz + cz * cx) + 2 * second * (2 * (cx * cx + cy * cy + cz * cz) - 3);
}

} // namespace bccsplat
