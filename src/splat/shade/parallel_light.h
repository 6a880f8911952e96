// SPDX-License-Identifier: Apache-2.0
// shade() for many samples of a parallel view: what depends on lights and view alone is made once.
#pragma once

#include <vector>

#include "splat/shade/light.h"

namespace bccsplat {

class ParallelLight {
 public:
  // to_viewer: unit vector.
  ParallelLight(const Lights& lights, const Vec3& to_viewer);
  // Returns what shade() returns, but for rounding.
  [[nodiscard]] Shading shade(const Vec3& gradient, double value) const;

 private:
  struct Source {
    Vec3 to_light{}, half{}; // unit vectors
    Vec3 diffuse{}, specular{};
    bool shines = true; // no light from behind does
  };
  std::vector<Source> sources_;
  double ambient_, shininess_;
  GradientNoise noise_;
};

} // namespace bccsplat
