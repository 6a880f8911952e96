// SPDX-License-Identifier: Apache-2.0
// Shading: two-sided Phong with directional lights, in world space.
//   colour * (ambient + diffuse sum_l light_l |N.L_l|) + specular sum_l light_l |N.H_l|^shininess
// N is the normalised gradient, L points to the light, H is halfway between L and the direction to the
// viewer. Where the gradient vanishes there is no surface: the sample is lit as if it faced every light,
// without highlight. Between that and a surface lie gradients that may be noise, which has directions, too,
// and glitters: |N.L_l| is w |N.L_l| + 1 - w there, and the highlight w times itself.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "base/vec.h"

namespace bccsplat {

struct Light {
  Vec3 direction{}; // towards the light, world space; zero: from the camera
  Vec3 color{1, 1, 1};
};

// The largest gradient that noise has, in value per world length: where the field is `value` from its base,
// constant + of_value |value|, for kernels ripple by a share of that.
struct GradientNoise {
  double constant = 0, of_value = 0;
  [[nodiscard]] double at(double value) const { return constant + of_value * std::fabs(value); }
};

// Gradients from so many times the noise on are surfaces.
inline constexpr double surface_over_noise = 3;

struct Lights {
  std::vector<Light> lights = std::vector<Light>(1); // GCC 12 doubts a copied list
  double ambient = 0.3, diffuse = 0.7, specular = 0.2, shininess = 20;
  GradientNoise noise; // none: every gradient is a surface's
  // Whether the volume stands in the way of its lights, and of what comes from all around.
  bool shadow = false, occlusion = false;
};

inline constexpr size_t lights_at_most = 8;

// Returns the weight w of a surface: rises smoothly from 0 at the noise to 1.
[[nodiscard]] inline double surface_weight(double gradient, double noise) {
  if (!(gradient > 0)) return 0;
  constexpr double steepness = surface_over_noise / (surface_over_noise - 1);
  const double t = std::clamp(steepness * (1 - noise / gradient), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

// Highlights below this are taken as 0. Less is soon no normal float, which many processors multiply a
// hundred times as slowly; the square of this still is one.
inline constexpr double least_highlight = 0x1p-60;

// Returns the cosine whose highlight is the least.
[[nodiscard]] inline float least_cosine(double shininess) {
  return shininess > 0 ? static_cast<float>(std::pow(least_highlight, 1 / shininess)) : 0.0f;
}

// What multiplies the colour, per channel, and what is added to it.
struct Shading {
  Vec3 scale{}, highlight{};
};

// The shares of light that come through to a place: from all around, and from each light.
struct LightThrough {
  double ambient = 1;
  std::span<const float> lights; // empty: all of it
};

// gradient: world space; to_viewer: unit vector; value: of the field, less its base.
[[nodiscard]] inline Shading shade(const Lights& lights, const Vec3& gradient, const Vec3& to_viewer,
                                   double value, const LightThrough& through = {}) {
  Shading s;
  const double around = lights.ambient * through.ambient;
  s.scale = {around, around, around};
  const double norm = length(gradient), weight = surface_weight(norm, lights.noise.at(value));
  for (size_t n = 0; n < lights.lights.size(); ++n) {
    const Light& light = lights.lights[n];
    const double share = through.lights.empty() ? 1 : static_cast<double>(through.lights[n]);
    const bool headlight = dot(light.direction, light.direction) == 0;
    const Vec3 to_light = headlight ? to_viewer : normalized(light.direction);
    double facing = 1, shine = 0;
    if (norm > 0) {
      facing = std::fabs(dot(gradient, to_light)) / norm;
      const Vec3 half = to_light + to_viewer;
      const double h = length(half);
      if (h > 0) shine = std::pow(std::fabs(dot(gradient, half)) / (norm * h), lights.shininess);
      if (shine < least_highlight) shine = 0;
    }
    s.scale = s.scale + (share * lights.diffuse * (weight * facing + (1 - weight))) * light.color;
    s.highlight = s.highlight + (share * lights.specular * (weight * shine)) * light.color;
  }
  return s;
}

} // namespace bccsplat
