// SPDX-License-Identifier: Apache-2.0
// The 3D field on a hyperplane: coefficients of a radial kernel on a 3D lattice, with its place in the 4D
// volume.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/vec.h"
#include "field/hyperplane.h"
#include "field/moment.h"
#include "field/scattered_field.h"
#include "field/slice_corrections.h"
#include "field/slice_labels.h"
#include "field/slice_mask.h"
#include "kernel/kernel.h"
#include "lattice/lattice.h"
#include "points/brick.h"

namespace bccsplat {

// Points this far beyond an end of the domain count as inside (lattice units): rounding of conversions.
[[nodiscard]] inline double domain_tolerance(double end) { return 1e-9 * (1 + end); }

// Immutable once made. Field value at a point p (lattice units) of the domain:
//   base + sum over kept sites s of coefficient(s) * kernel.space.value(|p - s|^2)     [/ lattice_sum if
//   normalised]   [+ corrections]
// where sites beyond the lattice's end planes hold the mirror images of those inside.
// Where points are scattered the sum is theirs, and no site is kept.
// A point whose nearest site is a hole has no value, and so has one that the mask says is missing.
struct Slice {
  Lattice3 lattice;
  SliceCosets coset;                  // coefficients relative to the base; CC slices use the first only
  Kernel kernel;                      // its spatial part reconstructs the slice
  float base = 0;                     // of the field: what no coefficient reaches has this value
  float air = 0;                      // of the volume; where the base is another no site is air
  bool has_holes = false;             // or a mask
  bool holes_by_mask = false;         // no site is a hole: the mask alone says what is missing
  std::array<double, 2> bounds{0, 0}; // no value lies outside

  // The domain is the box [domain_begin, domain_end] in lattice units, cut by `clip` (none for time and axis
  // slices). It begins at 0 but where planes or layers lie outside the source samples. An empty slice, of
  // a hyperplane that misses the volume, ends below 0: no point is inside.
  Vec3 domain_begin{}, domain_end{};
  std::vector<HalfSpace> clip;

  Affine3 lattice_to_slice; // lattice units -> slice space (u, v, w)
  Affine3 slice_to_world;
  Hyperplane hyperplane{0, 0, 0, 1, 0};
  Vec4 origin{};               // index space of slice space (0, 0, 0)
  std::array<Vec4, 3> basis{}; // index-space directions of u, v, w

  double frame = 0; // frame index of a time slice
  // How much finer an even slice's lattice (slice/even_slice.h) would have to be for its closest samples.
  double lacking = 1;
  // The file's corrections as this slice sees them; null: none.
  std::shared_ptr<const SliceCorrections> corrections;
  std::shared_ptr<const ScatteredField> scattered; // instead of coefficients; null: none
  std::shared_ptr<const SliceMask> mask;           // null: nothing is missing, or the lattice says what
  std::shared_ptr<const SliceLabels> labels; // values are those of the nearest sample; null: the field's
  uint64_t bytes_read = 0;
  double milliseconds = 0;

  // Position of a site in lattice units.
  [[nodiscard]] Vec3 site(int coset_index, const Int3& i) const {
    const double d = lattice.plane_distance();
    return {d * lattice.plane(coset_index, i[0]), d * lattice.plane(coset_index, i[1]),
            d * lattice.plane(coset_index, i[2])};
  }
  [[nodiscard]] bool is_time_slice() const {
    return hyperplane[0] == 0 && hyperplane[1] == 0 && hyperplane[2] == 0;
  }
  [[nodiscard]] Vec3 centre() const { return 0.5 * (domain_begin + domain_end); }
  [[nodiscard]] bool empty() const { return domain_end[0] < 0; }
  [[nodiscard]] bool inside(const Vec3& p) const;  // lattice units, inclusive with a tolerance
  [[nodiscard]] bool is_hole(const Vec3& p) const; // of a point inside
  [[nodiscard]] int64_t sites() const;
  [[nodiscard]] int64_t points() const; // sites that are not air
  [[nodiscard]] uint64_t bytes() const;
};

// Bounds of the field from the range of the coefficients: the kernel is nonnegative and its site sum exceeds
// 1 by its ripple only.
[[nodiscard]] std::array<double, 2> coefficient_bounds(const Slice& slice);
[[nodiscard]] std::array<double, 2> coefficient_bounds(const Slice& slice, const std::array<float, 2>& range);

// The slow double-precision reference: field value (absolute) and gradient (per lattice unit; may be null) at
// a point inside the domain, in lattice units.
[[nodiscard]] double evaluate_reference(const Slice& slice, const Vec3& p, Vec3* gradient);

// Value and gradient at points in lattice units; outside the domain or in holes NaN. gradients: empty or one
// per point. Returns how many points were outside and in holes.
struct EvaluateMisses {
  uint64_t outside = 0, holes = 0;
};
EvaluateMisses evaluate(const Slice& slice, std::span<const Vec3> points, std::span<float> values,
                        std::span<std::array<float, 3>> gradients);

} // namespace bccsplat
