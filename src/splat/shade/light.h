// SPDX-License-Identifier: Apache-2.0
// Shading: two-sided Phong with directional lights, in world space.
//   colour * (ambient + diffuse sum_l light_l |N.L_l|) + specular sum_l light_l |N.H_l|^shininess
// N is the normalised gradient, L points to the light, H is halfway between L and the direction to the
// viewer. Where the gradient vanishes there is no surface: the sample is lit as if it faced every light,
// without highlight.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "base/vec.h"

namespace bccsplat {

struct Light {
  Vec3 direction{}; // towards the light, world space; zero: from the camera
  Vec3 color{1, 1, 1};
};

struct Lights {
  std::vector<Light> lights = std::vector<Light>(1); // GCC 12 doubts a copied list
  double ambient = 0.3, diffuse = 0.7, specular = 0.2, shininess = 20;
};

// What multiplies the colour, per channel, and what is added to it.
struct Shading {
  Vec3 scale{}, highlight{};
};

// gradient: world space, any length; to_viewer: unit vector.
[[nodiscard]] inline Shading shade(const Lights& lights, const Vec3& gradient, const Vec3& to_viewer) {
  Shading s;
  s.scale = {lights.ambient, lights.ambient, lights.ambient};
  const double norm = length(gradient);
  for (const Light& light : lights.lights) {
    const bool headlight = dot(light.direction, light.direction) == 0;
    const Vec3 to_light = headlight ? to_viewer : normalized(light.direction);
    double facing = 1, shine = 0;
    if (norm > 0) {
      facing = std::fabs(dot(gradient, to_light)) / norm;
      const Vec3 half = to_light + to_viewer;
      const double h = length(half);
      if (h > 0) shine = std::pow(std::fabs(dot(gradient, half)) / (norm * h), lights.shininess);
    }
    s.scale = s.scale + (lights.diffuse * facing) * light.color;
    s.highlight = s.highlight + (lights.specular * shine) * light.color;
  }
  return s;
}

} // namespace bccsplat
