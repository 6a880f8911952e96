// SPDX-License-Identifier: Apache-2.0
// What missing data cost a picture: a sea with land, and the same field without a mask.
#include <cmath>
#include <memory>

#include "tests/bench/render/render.h"

namespace bccsplat::bench {
namespace {

// The samples below a bottom with hills and straits, about two fifths.
FrameMaskPtr land(int n, MemoryBudget& budget) {
  const std::array<int64_t, 3> samples{n, n, n};
  auto mask = std::make_shared<FrameMask>(samples,
                                          Reservation(budget, FrameMask::bytes_of(samples), "a mask"), false);
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        const double u = 1.0 * x / n, v = 1.0 * y / n;
        const double bottom = 0.42 + 0.22 * std::sin(9 * u + 1) * std::cos(8 * v) +
                              0.1 * std::sin(21 * u - 17 * v) + 0.03 * std::sin(55 * u + 49 * v);
        if (z > bottom * n) continue;
        const uint64_t at = (z * n + y) * n + x;
        mask->add(at, at + 1);
      }
  mask->count_blocks();
  return mask;
}

} // namespace

void render_coast(const Report& report) {
  BenchContext one(1);
  const int rounds = report.quick ? 1 : 5;
  std::vector<Row> rows;
  for (const int n : report.quick ? std::vector{24} : std::vector{128, 256}) {
    const int size = report.quick ? 48 : 512;
    const FieldScene field = marschner_lobb_scene(n);
    const SampledScene sea = sample_scene(field, LatticeKind::bcc, "default");
    SampledScene coast = sample_scene(field, LatticeKind::bcc, "default");
    const std::array<Vec4, 3> basis{Vec4{1, 0, 0, 0}, Vec4{0, 1, 0, 0}, Vec4{0, 0, 1, 0}};
    coast.slice.mask = std::make_shared<const SliceMask>(std::array<int64_t, 4>{n, n, n, 1}, TurningAxes{},
                                                         Vec4{}, basis, 0, std::vector{land(n, one.memory)});
    coast.slice.has_holes = coast.slice.holes_by_mask = true;
    const Camera camera = scene_camera(field, size, 0);
    const Scene whole = splat_scene(field, sea, camera), cut = splat_scene(field, coast, camera);
    for (const RenderMode mode : {RenderMode::composite, RenderMode::xray, RenderMode::maximum})
      for (const Quality q : {Quality::draft, Quality::normal}) {
        RenderOptions o;
        o.mode = mode, o.quality = q;
        const auto ms =
            least_ms(std::array{splat_method("filled", whole, o, one), splat_method("coast", cut, o, one)},
                     size, rounds);
        rows.push_back({figure("samples an axis", n, 0), word("mode", mode_name(mode)),
                        word("quality", quality_name(q)), figure("filled ms", ms[0], 1),
                        figure("with land ms", ms[1], 1), figure("with land / filled", ms[1] / ms[0], 2)});
      }
  }
  report.table("missing data: the land of a sea is not drawn, or filled and drawn", rows);
}

} // namespace bccsplat::bench
