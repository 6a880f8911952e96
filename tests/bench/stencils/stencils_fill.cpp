// SPDX-License-Identifier: Apache-2.0
// Samples by stencils: against the library's own field at the same places, and how fast.
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/bench/scene.h"
#include "tests/bench/stencils/stencil_fill.h"
#include "tests/bench/stencils/stencils.h"

namespace bccsplat::bench {
namespace {

struct Difference {
  double most = 0; // from the field
  double unscaled =
      0; // the same, of samples times the sum of their weights: the stencils' places and taps alone
};

// Of samples inside the domain from the field, every so many of them.
Difference from_field(const Slice& slice, const StencilView& view, const SampleSheets& sheets,
                      int64_t every) {
  const double plane = slice.lattice.plane_distance();
  std::vector<Vec3> places;
  std::vector<double> samples, sums;
  int64_t n = 0;
  for (const SampleSheet& s : sheets.all())
    for (int y = 0; y < sheets.height(); ++y)
      for (int x = 0; x < sheets.width(); ++x) {
        if (n++ % every != 0) continue;
        const auto k = static_cast<double>(s.k);
        Vec3 p;
        p[view.axes[0]] = plane * (view.origin[0] + k * view.shift[0] + s.first_u + x);
        p[view.axes[1]] = plane * (view.origin[1] + k * view.shift[1] + (s.first_v + y) * view.pitch_v);
        p[view.axes[2]] = plane * (view.origin[2] + k * view.shift[2]);
        if (!slice.inside(p)) continue;
        places.push_back(p);
        samples.push_back(s.samples[static_cast<std::ptrdiff_t>(y) * sheets.pitch() + x]);
        sums.push_back(sheets.sum(s, x, y));
      }
  std::vector<float> values(places.size());
  evaluate(slice, places, values, {});
  Difference d;
  for (size_t i = 0; i < values.size(); ++i) {
    const double field = static_cast<double>(values[i]) - slice.base;
    d.most = std::max(d.most, std::fabs(samples[i] - field));
    d.unscaled = std::max(d.unscaled, std::fabs(samples[i] * sums[i] - field));
  }
  return d;
}

double largest_difference(const SampleSheets& a, const SampleSheets& b) {
  double most = 0;
  for (size_t k = 0; k < a.all().size(); ++k)
    for (int y = 0; y < a.height(); ++y)
      for (int x = 0; x < a.width(); ++x) {
        const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(y) * a.pitch() + x;
        most =
            std::max(most, std::fabs(static_cast<double>(a.all()[k].samples[at] - b.all()[k].samples[at])));
      }
  return most;
}

// plain: and by loops without vectors, of which the largest difference is told.
Row fill_row_of(int n, double step, bool plain, int rounds) {
  const FieldScene field = marschner_lobb_scene(n);
  const SampledScene sampled = sample_scene(field, LatticeKind::bcc, "default");
  const Slice& slice = sampled.slice;
  const StencilView view =
      make_stencil_view(slice, resolve_camera(scene_camera(field, 512, 0)), 512, 512, step);
  const auto range = sheet_range(slice, view.view);
  constexpr double margin = 1; // planes
  constexpr int site_margin = 8;
  SiteArray sites;
  const double prepare = cpu_seconds([&] { sites = make_site_array(slice, view.axes, site_margin); });
  SampleSheets sheets;
  sheets.begin(slice, view, sites, KernelForm::exact, range[0], range[1], margin);
  double fill = 1e300;
  for (int r = 0; r < rounds; ++r) fill = std::min(fill, cpu_seconds([&] { sheets.fill(); }));
  const auto samples = static_cast<double>(sheets.samples());
  const Difference d =
      from_field(slice, view, sheets, std::max(int64_t{1}, static_cast<int64_t>(samples) / 50000));
  double from_plain = std::numeric_limits<double>::quiet_NaN();
  if (plain) {
    SampleSheets reference;
    reference.begin(slice, view, sites, KernelForm::exact, range[0], range[1], margin);
    reference.fill(true);
    from_plain = largest_difference(sheets, reference);
  }
  return {figure("lattice of, cubed", n, 0),
          figure("step along the rays T", step, 2),
          figure("Msamples", 1e-6 * samples, 2),
          figure("taps", sheets.taps_per_sample(), 1),
          figure("sites ms", 1e3 * prepare, 1),
          figure("fill ms", 1e3 * fill, 2),
          figure("ns / sample", 1e9 * fill / samples, 3),
          figure("Gtaps/s", 1e-9 * samples * sheets.taps_per_sample() / fill, 1),
          figure("sites MiB", static_cast<double>(sites.floats) * sizeof(float) / 1048576, 1),
          figure("sheets MiB", static_cast<double>(sheets.bytes()) / 1048576, 1),
          figure("most from evaluate()", d.most, 5),
          figure("the same, weights not made to sum to 1", d.unscaled, 7),
          figure("most from plain loops", from_plain, 8)};
}

} // namespace

void stencils_fill(const Report& report) {
  std::vector<Row> rows;
  for (const int n : report.quick ? std::vector{24} : std::vector{128, 256})
    for (const double step : {1.0, 0.5}) rows.push_back(fill_row_of(n, step, n < 256, report.quick ? 1 : 7));
  report.table("filling sheets by stencils, one thread", rows);
}

void stencils_large(const Report& report) {
  report.table("filling sheets by stencils, one thread",
               {fill_row_of(report.quick ? 32 : 512, 1, false, report.quick ? 1 : 3)});
}

} // namespace bccsplat::bench
