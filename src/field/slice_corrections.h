// SPDX-License-Identifier: Apache-2.0
// Corrections as a slice has them: values at points of a grid of spacing 1 in slice space, which fall off to
// the next points along its axes. They are part of the slice's field.
#pragma once

#include <memory>

#include "base/vec.h"
#include "field/fall_off.h"
#include "field/sparse_grid.h"

namespace bccsplat {

struct SliceCorrections {
  Vec3 origin{}; // of the grid, slice space
  CorrectionShape shape = CorrectionShape::tent;
  SparseGrid add;
  SparseGrid set; // where the slice has a hole: the value itself, at the points alone

  [[nodiscard]] bool empty() const { return add.empty() && set.empty(); }
  [[nodiscard]] uint64_t bytes() const { return add.bytes() + set.bytes(); }
  // Returns what is added at a point of slice space, and to its gradient per unit of slice space unless null.
  [[nodiscard]] float at(const Vec3& uvw, Vec3* gradient) const;
  // The value of a point that lies in a hole; null: it has none.
  [[nodiscard]] const float* set_at(const Vec3& uvw) const;
  // Adds to the values of a grid in slice space, sample (i, j, k) at from + step * (i, j, k), x fastest; NaN
  // stay but where values are set.
  void add_to_grid(const Vec3& from, const Vec3& step, const Int3& dims, float* values) const;
};

} // namespace bccsplat
