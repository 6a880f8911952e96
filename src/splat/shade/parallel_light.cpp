// SPDX-License-Identifier: Apache-2.0
#include "splat/shade/parallel_light.h"

#include <cmath>

namespace bccsplat {
namespace {

// x^power for x in [0, 1]; by squaring where the power is a small whole number, as it is by default.
double power_of(double x, double power) {
  constexpr double largest = 1024;
  if (!(power >= 0 && power <= largest && power == std::floor(power))) return std::pow(x, power);
  double result = 1;
  for (auto n = static_cast<unsigned>(power); n > 0; n >>= 1, x *= x)
    if (n & 1) result *= x;
  return result;
}

} // namespace

ParallelLight::ParallelLight(const Lights& lights, const Vec3& to_viewer)
    : ambient_(lights.ambient), shininess_(lights.shininess), noise_(lights.noise) {
  for (const Light& light : lights.lights) {
    const bool headlight = dot(light.direction, light.direction) == 0;
    const Vec3 to_light = headlight ? to_viewer : normalized(light.direction), half = to_light + to_viewer;
    const double h = length(half);
    sources_.push_back({to_light, h > 0 ? (1 / h) * half : Vec3{}, lights.diffuse * light.color,
                        lights.specular * light.color, h > 0});
  }
}

Shading ParallelLight::shade(const Vec3& gradient, double value) const {
  Shading s{{ambient_, ambient_, ambient_}, {}};
  const double norm = std::sqrt(dot(gradient, gradient)), weight = surface_weight(norm, noise_.at(value));
  const Vec3 normal = norm > 0 ? (1 / norm) * gradient : Vec3{};
  for (const Source& source : sources_) {
    const double facing = norm > 0 ? std::fabs(dot(normal, source.to_light)) : 1;
    double shine = 0;
    if (norm > 0 && source.shines) shine = power_of(std::fabs(dot(normal, source.half)), shininess_);
    if (shine < least_highlight) shine = 0;
    s.scale = s.scale + (weight * facing + (1 - weight)) * source.diffuse;
    s.highlight = s.highlight + (weight * shine) * source.specular;
  }
  return s;
}

} // namespace bccsplat
