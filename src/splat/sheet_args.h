// From a completed sheet and its neighbours to what its pixels are classified and shaded from.
#pragma once

#include <algorithm>
#include <cstdint>

#include "splat/sheet.h"
#include "splat/surface.h"
#include "splat/view.h"

namespace bccsplat {

// differences: neighbours on either side that gradients look at, 0 for the analytic sums. radius: of the
// kernel, lattice units.
[[nodiscard]] GradientBasis gradient_basis(const SheetView& view, int64_t k, int differences, double radius);

// Frame index of the sheet's samples.
[[nodiscard]] std::array<float, 4> sheet_time(const TimeField& time, const SheetView& view, int64_t k);

// Sets number, planes and gradient of sheet k. `plane(k, quantity)` is as SheetSource's.
template<class Plane>
void set_sheet(SheetArgs& a, const SheetView& view, int64_t k, bool analytic, int differences, double radius,
               const Plane& plane) {
  a.k = static_cast<float>(k);
  a.front = k == view.first_sheet() ? 2 : 0.5f;
  a.alike = !view.perspective;
  if (a.alike) a.to_viewer = to_viewer(view, 0, 0);
  a.value = plane(k, size_t{0});
  a.central = differences == 1, a.fourth_order = differences == 2;
  if (differences > 0) {
    // Nothing is sampled before the first sheet in front of an eye: fewer neighbours there.
    const auto front = std::min<int64_t>(k - view.first_sheet(), differences);
    a.after = plane(k + 1, size_t{0}), a.before = front > 0 ? plane(k - 1, size_t{0}) : a.value;
    a.depth_scale = front == 2 ? 8.0f / 12 : front == 1 ? 0.5f : 1.0f;
    a.after2 = a.before2 = a.value, a.depth_scale2 = 0;
    if (front == 2)
      a.after2 = plane(k + 2, size_t{0}), a.before2 = plane(k - 2, size_t{0}), a.depth_scale2 = -1.0f / 12;
  } else if (analytic) {
    a.sum_i = plane(k, size_t{1}), a.sum_j = plane(k, size_t{2}), a.sum_k = plane(k, size_t{3});
  }
  if (differences > 0 || analytic) a.basis = gradient_basis(view, k, differences, radius);
}

} // namespace bccsplat
