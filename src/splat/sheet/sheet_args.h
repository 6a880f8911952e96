// SPDX-License-Identifier: Apache-2.0
// From a completed sheet and its neighbours to what its pixels are classified and shaded from.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>

#include "shade/surface.h"
#include "splat/sheet/sheet.h"
#include "view/view.h"

namespace bccsplat {

// `differences` is the number of neighbours on either side that gradients look at, 0 for the analytic sums.
[[nodiscard]] GradientBasis gradient_basis(const Slice& slice, const SheetView& view, int64_t k,
                                           int differences);

// Sets where the samples of sheet k lie in the cells of the lattice, whose sums are set. radius: of the
// kernel.
void set_ripple(const SheetView& view, int64_t k, double radius, SheetRipple& ripple);

// The field is known this far outside the domain (make_points), lattice units.
inline constexpr double samples_beyond = 2;

// Returns the frame index of the sheet's samples, as SheetArgs::time.
[[nodiscard]] std::array<float, 4> sheet_time(const TimeField& time, const SheetView& view, int64_t k);

// Returns how many sheets on either side values halfway between sheets are made of: 2, the cubic through four
// samples, or 1, the line through two, where four would reach beyond the points of the domain's mirror
// images.
[[nodiscard]] int halfway_sheets(const SheetView& view);

// Sets what segments are classified from by integrals. `plane(k)` is as SheetSource's of values.
template<class Plane>
void set_halfway(SheetArgs& a, const SheetView& view, int64_t k, int sheets, const Plane& plane) {
  const float* const here = a.field.value;
  // From k in the direction of the half; nothing is sampled before the first sheet in front of an eye.
  const auto make = [&](int64_t toward) {
    const int64_t first = view.first_sheet();
    const auto exists = [&](int64_t n) { return k + n * toward >= first; };
    const auto at = [&](int64_t n) { return exists(n) ? plane(k + n * toward) : here; };
    Halfway h{{here, at(1), sheets == 1 ? here : at(-1), sheets == 1 ? here : at(2)}, {}};
    if (!exists(1))
      h.weight = {1, 0, 0, 0};
    else if (sheets == 1)
      h.weight = {0.5f, 0.5f, 0, 0};
    else if (!exists(2)) // the parabola through those nearest to it
      h.weight = {0.75f, 0.375f, -0.125f, 0};
    else if (!exists(-1))
      h.weight = {0.375f, 0.75f, 0, -0.125f};
    else
      h.weight = {0.5625f, 0.5625f, -0.0625f, -0.0625f};
    if (toward < 0) { // in the order of the sheets: both segments that meet here get the same bits
      std::swap(h.plane[0], h.plane[1]), std::swap(h.plane[2], h.plane[3]);
      std::swap(h.weight[0], h.weight[1]), std::swap(h.weight[2], h.weight[3]);
    }
    return h;
  };
  a.halves = {.preintegrated = true,
              .known = static_cast<float>(samples_beyond / view.step),
              .front = make(-1),
              .back = make(1)};
}

// What the differences of sheets k + 1 and k - 1, k + 2 and k - 2 are multiplied by to be a slope per sheet,
// the sheets being `along` lattice units apart along the rays, and pixels `across`: exact for constant slopes
// and, where pixels are much closer, for one wave.
struct DepthWeights {
  float near = 0, far = 0;
};
[[nodiscard]] DepthWeights depth_weights(double along, double across);

// Sets number, planes and gradient of sheet k, whose tile, lights and lattice sums are set. `plane(k,
// quantity)` is as SheetSource's.
template<class Plane>
void set_sheet(SheetArgs& a, const Slice& slice, const SheetView& view, int64_t k, bool analytic,
               int differences, const Plane& plane) {
  a.segment = {.k = static_cast<float>(k), .front = k == view.first_sheet() ? 2 : 0.5f};
  a.shading.alike = !view.perspective;
  if (a.shading.alike) a.shading.to_viewer = to_viewer(view, 0, 0);
  a.field.value = plane(k, size_t{0});
  if (differences > 0) {
    // Nothing is sampled before the first sheet in front of an eye, so that there are fewer neighbours.
    const auto front = std::min<int64_t>(k - view.first_sheet(), differences);
    const float* const here = a.field.value;
    const bool lit = a.shading.lights->diffuse != 0 || a.shading.lights->specular != 0;
    const DepthWeights two =
        depth_weights(length(view.ray(0.5 * view.width, 0.5 * view.height)),
                      view.scale(static_cast<double>(k)) * std::max(length(view.ex), length(view.ey)));
    a.differences = {.neighbours = differences,
                     .before = front > 0 ? plane(k - 1, size_t{0}) : here,
                     .after = plane(k + 1, size_t{0}),
                     .before2 = front == 2 ? plane(k - 2, size_t{0}) : here,
                     .after2 = front == 2 ? plane(k + 2, size_t{0}) : here,
                     .depth_scale = front == 2   ? two.near
                                    : front == 1 ? 0.5f
                                                 : 1.0f,
                     .depth_scale2 = front == 2 ? two.far : 0.0f,
                     .halves = lit && front > 0};
  } else if (analytic) {
    a.analytic.i = plane(k, size_t{1}), a.analytic.j = plane(k, size_t{2}),
    a.analytic.k = plane(k, size_t{3});
    if (a.analytic.ripple.sums) set_ripple(view, k, slice.kernel.space.radius, a.analytic.ripple);
  }
  if (differences == 0 && !analytic) return;
  a.basis = gradient_basis(slice, view, k, differences);
  a.shading.noise = static_cast<float>(a.shading.lights->noise.constant * a.basis.enlarged);
  a.shading.noise_of_value = static_cast<float>(a.shading.lights->noise.of_value * a.basis.enlarged);
}

} // namespace bccsplat
