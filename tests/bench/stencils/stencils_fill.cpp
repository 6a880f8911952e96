// SPDX-License-Identifier: Apache-2.0
// Samples by stencils: against the library's own field at the same places, and how fast.
#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/bench/scene.h"
#include "tests/bench/stencils/stencil_fill.h"
#include "tests/bench/stencils/stencils.h"

namespace bccsplat::bench {
namespace {

struct Difference {
  double most = 0, rms = 0;
};

// Of samples inside the domain from the field, every so many of them.
Difference from_field(const Slice& slice, const StencilView& view, const SampleSheets& sheets, int every) {
  const double plane = slice.lattice.plane_distance();
  std::vector<Vec3> places;
  std::vector<float> samples;
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
        samples.push_back(slice.base + s.samples[static_cast<std::ptrdiff_t>(y) * sheets.pitch() + x]);
      }
  std::vector<float> values(places.size());
  evaluate(slice, places, values, {});
  Difference d;
  for (size_t i = 0; i < values.size(); ++i) {
    const double off = std::fabs(static_cast<double>(values[i] - samples[i]));
    d.most = std::max(d.most, off), d.rms += off * off;
  }
  d.rms = std::sqrt(d.rms / static_cast<double>(std::max<size_t>(values.size(), 1)));
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

} // namespace

void stencils_fill(const Report& report) {
  std::vector<Row> rows;
  for (const int n : report.quick ? std::vector{24} : std::vector{128, 256}) {
    const FieldScene field = marschner_lobb_scene(n);
    const SampledScene sampled = sample_scene(field, LatticeKind::bcc, "default");
    const Slice& slice = sampled.slice;
    const WorldCamera camera = resolve_camera(scene_camera(field, 512, 0));
    for (const double step : {1.0, 0.5}) {
      const StencilView view = make_stencil_view(slice, camera, 512, 512, step);
      const auto range = sheet_range(slice, view.view);
      SampleSheets sheets, reference;
      constexpr double margin = 1; // plane
      SiteArray sites;
      const double prepare = cpu_seconds([&] { sites = make_site_array(slice, view.axes, 8); });
      sheets.begin(slice, view, range[0], range[1], margin);
      double fill = 1e300;
      for (int r = 0; r < (report.quick ? 1 : 7); ++r)
        fill = std::min(fill, cpu_seconds([&] { sheets.fill(slice, view, sites); }));
      const Difference d = from_field(slice, view, sheets, report.quick ? 7 : 97);
      reference.begin(slice, view, range[0], range[1], margin);
      reference.fill(slice, view, sites, KernelForm::exact, true);
      const auto samples = static_cast<double>(sheets.samples());
      rows.push_back({figure("lattice of, cubed", n, 0), figure("step along the rays T", step, 2),
                      figure("Msamples", 1e-6 * samples, 2), figure("taps", sheets.taps_per_sample(), 1),
                      figure("sites ms", 1e3 * prepare, 1), figure("fill ms", 1e3 * fill, 2),
                      figure("ns / sample", 1e9 * fill / samples, 3),
                      figure("Gtaps/s", 1e-9 * samples * sheets.taps_per_sample() / fill, 1),
                      figure("sheets MiB", static_cast<double>(sheets.bytes()) / 1048576, 1),
                      figure("most from evaluate()", d.most, 6), figure("rms from it", d.rms, 6),
                      word("most from plain loops", number(largest_difference(sheets, reference), 8))});
    }
  }
  report.table("filling sheets by stencils, one thread", rows);
}

} // namespace bccsplat::bench
