// SPDX-License-Identifier: Apache-2.0
// Sums of the kernel around points the slow way, bounds of the field, and what belongs to a slice.
#include "field/slice.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "field/footprint/hole.h"
#include "kernel/cc_kernel.h"

namespace bccsplat {

bool Slice::inside(const Vec3& p) const {
  for (size_t a = 0; a < 3; ++a) {
    const double end = domain_end[a], tolerance = domain_tolerance(end);
    if (!(p[a] >= domain_begin[a] - tolerance && p[a] <= end + tolerance)) return false;
  }
  return std::all_of(clip.begin(), clip.end(),
                     [&](const HalfSpace& h) { return dot(h.normal, p) + h.offset >= -domain_tolerance(0); });
}

bool Slice::is_hole(const Vec3& p) const {
  if (!has_holes) return false;
  return (mask && mask->missing(lattice_to_slice.point(p))) ||
         (!holes_by_mask && is_hole_at({&coset[0], lattice.bcc ? &coset[1] : nullptr}, p));
}

int64_t Slice::points() const { return base != air ? sites() : coset.kept_sites(); }

int64_t Slice::sites() const {
  int64_t n = 0;
  for (int c = 0; c < lattice.cosets(); ++c) {
    const Int3 dims = lattice.dims(c);
    n += int64_t{dims[0]} * dims[1] * dims[2];
  }
  return n;
}

uint64_t Slice::bytes() const { return coset.bytes() + (corrections ? corrections->bytes() : 0); }

std::array<double, 2> coefficient_bounds(const Slice& slice) {
  constexpr size_t lanes = 16; // kept apart, so that compilers may use vectors
  std::array<float, lanes> low{}, high{};
  for (const BrickLayer& layer : slice.coset)
    for (size_t s = 0; s < layer.brick_slots(); ++s)
      if (const Brick* b = layer.brick(s))
        for (size_t i = 0; i < brick_sites; i += lanes)
          for (size_t k = 0; k < lanes; ++k) {
            low[k] = std::min(low[k], b->value[i + k]);
            high[k] = std::max(high[k], b->value[i + k]);
          }
  return coefficient_bounds(
      slice, {*std::min_element(low.begin(), low.end()), *std::max_element(high.begin(), high.end())});
}

std::array<double, 2> coefficient_bounds(const Slice& slice, const std::array<float, 2>& range) {
  const double low = std::min(range[0], 0.0f), high = std::max(range[1], 0.0f);
  const double most = largest_site_sum(slice.lattice.bcc);
  return {slice.base + most * low, slice.base + most * high};
}

double evaluate_reference(const Slice& slice, const Vec3& p, Vec3* gradient) {
  if (slice.scattered) {
    float value = 0;
    Vec3 of_points;
    slice.scattered->at({&p, 1}, {&value, 1}, {&of_points, 1});
    if (gradient) *gradient = of_points;
    return slice.base + value;
  }
  const Lattice3& lattice = slice.lattice;
  const double pitch = lattice.bcc ? std::numbers::sqrt2 : 1.0;
  const double radius = slice.kernel.space.radius;
  double sum = 0;
  Vec3 slope{};
  for (int c = 0; c < lattice.cosets(); ++c) {
    const BrickLayer& layer = slice.coset[c];
    std::array<int32_t, 3> first, last;
    for (size_t a = 0; a < 3; ++a) {
      first[a] = static_cast<int32_t>(std::ceil((p[a] - radius) / pitch - 0.5 * c));
      last[a] = static_cast<int32_t>(std::floor((p[a] + radius) / pitch - 0.5 * c));
    }
    for (int32_t z = first[2]; z <= last[2]; ++z)
      for (int32_t y = first[1]; y <= last[1]; ++y)
        for (int32_t x = first[0]; x <= last[0]; ++x) {
          const double value =
              layer.value(lattice.mirror(0, c, x), lattice.mirror(1, c, y), lattice.mirror(2, c, z));
          if (value == 0) continue;
          const Vec3 v = p - Vec3{pitch * (x + 0.5 * c), pitch * (y + 0.5 * c), pitch * (z + 0.5 * c)};
          const double r2 = dot(v, v);
          sum += value * slice.kernel.space.value(r2);
          slope = slope + (2 * value * slice.kernel.space.slope(r2)) * v;
        }
  }
  if (slice.kernel.normalised) {
    const double n = lattice_sum(slice.kernel, lattice.bcc, p[0], p[1], p[2]);
    if (gradient) {
      // Quotient rule; the lattice sum's own gradient by central differences (it is smooth and known in
      // closed form).
      constexpr double h = 1e-4;
      for (size_t a = 0; a < 3; ++a) {
        Vec3 low = p, high = p;
        low[a] -= h, high[a] += h;
        const double dn = (lattice_sum(slice.kernel, lattice.bcc, high[0], high[1], high[2]) -
                           lattice_sum(slice.kernel, lattice.bcc, low[0], low[1], low[2])) /
                          (2 * h);
        slope[a] = (slope[a] - sum / n * dn) / n;
      }
    }
    sum /= n;
  }
  if (slice.corrections) {
    Vec3 per_uvw;
    sum += slice.corrections->at(slice.lattice_to_slice.point(p), &per_uvw);
    slope = slope + slice.lattice_to_slice.transposed(per_uvw);
  }
  if (gradient) *gradient = slope;
  return slice.base + sum;
}

} // namespace bccsplat
