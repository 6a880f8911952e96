// SPDX-License-Identifier: Apache-2.0
// A slice's field that is a sum over points which stand on no lattice: what splatters and searches ask for in
// place of coefficients.
#pragma once

#include <functional>
#include <span>

#include "base/vec.h"

namespace bccsplat {

// Samples of a sheet: pixel (i, j) of the picture is at origin + i per_i + j per_j in lattice units of the
// slice; `values` are those of the columns x .. x + width - 1 and the rows from y on, `pitch` floats apart.
struct ScatterSheet {
  Vec3 origin{}, per_i{}, per_j{};
  int x = 0, y = 0, width = 0, height = 0, pitch = 0;
  float* values = nullptr;
};

class ScatteredField {
 public:
  ScatteredField() = default;
  ScatteredField(const ScatteredField&) = delete;
  ScatteredField& operator=(const ScatteredField&) = delete;
  virtual ~ScatteredField() = default;

  // Sets values relative to the base of the field and gradients per lattice unit of the slice.
  virtual void at(std::span<const Vec3> points, std::span<float> values, std::span<Vec3> gradients) const = 0;
  // Splats all points within reach of a sheet onto samples that are 0, relative to the base. Returns whether
  // there were any. A sample's value does not depend on which others are asked for.
  [[nodiscard]] virtual bool splat(const ScatterSheet& sheet) const = 0;
  // Hands every point to body(place, value, share): lattice units of the slice, the sample relative to the
  // base, and the part of it that counts there.
  virtual void each_point(const std::function<void(const Vec3&, float, float)>& body) const = 0;
};

} // namespace bccsplat
