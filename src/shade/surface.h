// SPDX-License-Identifier: Apache-2.0
// Points on a surface: where the field along a ray passes the iso value, found by the field itself, more
// finely than sheets are apart.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "field/footprint/footprint.h"
#include "field/lattice_sums.h"
#include "field/slice.h"
#include "shade/light.h"
#include "view/view.h"

namespace bccsplat {

// A crossing between two sheets: the ray through (i, j) of the picture, sheet numbers low < high with values
// on either side and the field's slopes there, roughly and per sheet (NaN: unknown).
struct Crossing {
  double i = 0, j = 0;
  double low = 0, high = 0, value_low = 0, value_high = 0, slope_low = 0, slope_high = 0;
  uint32_t number = 0; // by which the caller knows the ray
};

struct SurfacePoint {
  double k = 0;    // sheet number
  Vec3 position{}; // lattice units
  Vec3 gradient{}; // world space
};

// A slice, which must outlive it, and what the sums of its footprints need to know.
struct SurfaceField {
  explicit SurfaceField(const Slice& of, std::shared_ptr<const LatticeSums> of_kernel = nullptr);
  const Slice& slice;
  std::shared_ptr<const LatticeSums> sums; // whose ripple gradients are lit without; null: with it
  FootprintPlan footprints;
  // The gradient that surfaces are lit by, of field_at()'s at a point, with the value there.
  [[nodiscard]] Vec3 lit_gradient(const Vec3& p, double value, const Vec3& gradient) const;
  // The same for many points, in place.
  void make_lit(std::span<const Vec3> points, std::span<const double> values,
                std::span<Vec3> gradients) const;
};

// Computes values relative to the base of the field and gradients per lattice unit at points in or near the
// domain, corrections included.
void field_at(const SurfaceField& field, std::span<const Vec3> points, std::span<float> values,
              std::span<Vec3> gradients);

// Finds the root of field = target, relative to the base, within each crossing. A root is near enough when
// the last step towards it was at most `tolerance` sheets; the gradient is the one from before that step.
[[nodiscard]] std::vector<SurfacePoint> refine_crossings(const SurfaceField& field, const SheetView& view,
                                                         double target, std::span<const Crossing> crossings,
                                                         double tolerance);

// Each interval has both ends on one side of the target, which its ray may pass twice in between. Returns,
// for those that do, the beginning of the interval and a point beyond the surface.
[[nodiscard]] std::vector<Crossing> find_grazes(const SurfaceField& field, const SheetView& view,
                                                double target, std::span<const Crossing> intervals);

// Unit vector from a sample to the viewer, world space.
[[nodiscard]] inline Vec3 to_viewer(const SheetView& view, double i, double j) {
  return -1.0 * normalized(view.lattice_to_world.vector(view.ray(i, j)));
}

// How near a root is found, in sheets: nearer costs a tenth of a picture and shows in none
// (tests/bench/notes/isosurfaces.md).
inline constexpr double root_tolerance = 0.01;

// Returns the colour that light makes of a classified one.
[[nodiscard]] inline std::array<float, 3> lit_color(const std::array<float, 4>& color, const Shading& lit) {
  std::array<float, 3> out;
  for (size_t c = 0; c < 3; ++c)
    out[c] = color[c] * static_cast<float>(lit.scale[c]) + static_cast<float>(lit.highlight[c]);
  return out;
}

// Frame index at a point of the slice, lattice units: offset + gradient . p.
struct TimeField {
  double offset = 0;
  Vec3 gradient{};
  explicit TimeField(const Slice& slice);
  [[nodiscard]] double at(const Vec3& p) const { return offset + dot(gradient, p); }
};

} // namespace bccsplat
