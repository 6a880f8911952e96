// SPDX-License-Identifier: Apache-2.0
#include "splat/sheet/sheet_args.h"

#include <cmath>
#include <numbers>

namespace bccsplat {

namespace {

// A power of two that brings x near 1.
double near_one(double x) { return std::isnormal(x) ? std::ldexp(1.0, -std::ilogb(x)) : 1; }

} // namespace

DepthWeights depth_weights(double along, double across) {
  // Weights exact for the fourth degree fall short of the slope of waves, the more so the farther apart the
  // sheets are. A shorter wave than this would bring more to fields near the band limit, and take from smooth
  // ones: their waves, longer than this one, come out too steep (tests/bench/notes/differences.md). What
  // falls short alike across pixels turns no gradient, and is left.
  constexpr double exact_wave = 0.1, farthest = 2; // cycles per lattice unit; lattice units
  const double distance = std::sqrt(std::max(0.0, along * along - across * across));
  const double angle = 2 * std::numbers::pi * exact_wave * std::min(distance, farthest);
  // 2 near sin(angle) + 2 far sin(2 angle) = angle, and 2 near + 4 far = 1; of small angles the series.
  const double sine = std::sin(angle);
  const double far =
      angle < 1e-2 ? -1.0 / 12 - angle * angle / 60 : (sine - angle) / (4 * sine * (1 - std::cos(angle)));
  return {static_cast<float>(0.5 - 2 * far), static_cast<float>(far)};
}

GradientBasis gradient_basis(const Slice& slice, const SheetView& view, int64_t k, int differences) {
  const Affine3 to_lattice = view.lattice_to_world.inverse();
  const double scale = view.scale(static_cast<double>(k));
  GradientBasis basis;
  Vec3 x, y, z;
  if (differences > 0) {
    x = to_lattice.transposed((1 / scale) * view.gx);
    y = to_lattice.transposed((1 / scale) * view.gy);
    z = to_lattice.transposed((1 / view.step) * view.normal);
    basis.slant_x = static_cast<float>(dot(view.gx, view.ez) / scale);
    basis.slant_y = static_cast<float>(dot(view.gy, view.ez) / scale);
    basis.slant_per_x = basis.slant_per_y = view.perspective ? static_cast<float>(1 / scale) : 0.0f;
  } else {
    // d phi / dp = phi'(u) du/dp with u = 1 - |p - site|^2 / R^2.
    const double radius = slice.kernel.space.radius, factor = -2 / (radius * radius);
    x = to_lattice.transposed((factor * scale) * view.ex);
    y = to_lattice.transposed((factor * scale) * view.ey);
    z = to_lattice.transposed((factor * view.step) * view.normal);
  }
  const double shorter = near_one(std::max({length(x), length(y), length(z)}));
  for (size_t a = 0; a < 3; ++a) {
    basis.x[a] = static_cast<float>(shorter * x[a]);
    basis.y[a] = static_cast<float>(shorter * y[a]);
    basis.z[a] = static_cast<float>(shorter * z[a]);
  }
  // Values relative to the base may be of any unit.
  const double base = slice.base;
  const double largest = std::max(slice.bounds[1] - base, base - slice.bounds[0]);
  const double unit = std::min(near_one(largest), 0x1p126);
  basis.unit = static_cast<float>(unit);
  basis.enlarged = shorter * unit;
  return basis;
}

void set_ripple(const SheetView& view, int64_t k, double radius, SheetRipple& r) {
  const auto sheet = static_cast<double>(k);
  const double cell = r.sums->cell(), scale = view.scale(sheet);
  const Vec3 first = view.sample(0, 0, sheet);
  // Sums times this are gradients, as in gradient_basis().
  const double factor = -2 / (radius * radius);
  for (size_t n = 0; n < 3; ++n) {
    r.at[n] = static_cast<float>(first[n] / cell - std::floor(first[n] / cell));
    r.per_x[n] = static_cast<float>(scale * view.ex[n] / cell);
    r.per_y[n] = static_cast<float>(scale * view.ey[n] / cell);
    r.sum_i[n] = static_cast<float>(view.gx[n] / (factor * scale));
    r.sum_j[n] = static_cast<float>(view.gy[n] / (factor * scale));
    r.sum_k[n] = static_cast<float>(view.normal[n] / (factor * view.step));
  }
}

int halfway_sheets(const SheetView& view) {
  double longest = 0;
  for (const double i : {0.0, static_cast<double>(view.width - 1)})
    for (const double j : {0.0, static_cast<double>(view.height - 1)})
      longest = std::max(longest, length(view.ray(i, j)));
  return 2 * longest <= 1.25 * samples_beyond ? 2 : 1;
}

std::array<float, 4> sheet_time(const TimeField& time, const SheetView& view, int64_t k) {
  const double scale = view.scale(static_cast<double>(k));
  return {static_cast<float>(time.at(view.sample(0, 0, static_cast<double>(k)))),
          static_cast<float>(scale * dot(time.gradient, view.ex)),
          static_cast<float>(scale * dot(time.gradient, view.ey)), 0};
}

} // namespace bccsplat
