// SPDX-License-Identifier: Apache-2.0
// shade() for many samples: what depends on lights alone, and on a view with parallel rays, is made once.
#pragma once

#include <vector>

#include "shade/light.h"

namespace bccsplat {

class ViewLight {
 public:
  // to_viewer: unit vector.
  ViewLight(const Lights& lights, const Vec3& to_viewer);
  // Returns what shade() returns, but for rounding.
  [[nodiscard]] Shading shade(const Vec3& gradient, double value) const;
  // The same where the viewer is elsewhere.
  [[nodiscard]] Shading shade(const Vec3& gradient, double value, const Vec3& to_viewer) const;

 private:
  struct Source {
    Vec3 to_light{}, half{}; // unit vectors
    Vec3 diffuse{}, specular{};
    bool shines = true;     // no light from behind does
    bool headlight = false; // from the viewer
    void look_from(const Vec3& to_viewer);
  };
  template<class SourceOf> Shading sum(const Vec3& gradient, double value, const SourceOf& source_of) const;
  std::vector<Source> sources_;
  double ambient_, shininess_;
  GradientNoise noise_;
};

} // namespace bccsplat
