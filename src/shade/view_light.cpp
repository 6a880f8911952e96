// SPDX-License-Identifier: Apache-2.0
#include "shade/view_light.h"

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

void ViewLight::Source::look_from(const Vec3& to_viewer) {
  if (headlight) to_light = to_viewer;
  const Vec3 sum = to_light + to_viewer;
  const double h = std::sqrt(dot(sum, sum));
  shines = h > 0, half = shines ? (1 / h) * sum : Vec3{};
}

ViewLight::ViewLight(const Lights& lights, const Vec3& to_viewer)
    : ambient_(lights.ambient), shininess_(lights.shininess), noise_(lights.noise) {
  for (const Light& light : lights.lights) {
    Source source;
    source.headlight = dot(light.direction, light.direction) == 0;
    if (!source.headlight) source.to_light = normalized(light.direction);
    source.diffuse = lights.diffuse * light.color, source.specular = lights.specular * light.color;
    source.look_from(to_viewer);
    sources_.push_back(source);
  }
}

template<class SourceOf>
Shading ViewLight::sum(const Vec3& gradient, double value, const SourceOf& source_of) const {
  Shading s{{ambient_, ambient_, ambient_}, {}};
  const double norm = std::sqrt(dot(gradient, gradient)), weight = surface_weight(norm, noise_.at(value));
  const Vec3 normal = norm > 0 ? (1 / norm) * gradient : Vec3{};
  for (const Source& kept : sources_) {
    const auto& source = source_of(kept);
    const double facing = norm > 0 ? std::fabs(dot(normal, source.to_light)) : 1;
    double shine = 0;
    if (norm > 0 && source.shines) shine = power_of(std::fabs(dot(normal, source.half)), shininess_);
    if (shine < least_highlight) shine = 0;
    s.scale = s.scale + (weight * facing + (1 - weight)) * source.diffuse;
    s.highlight = s.highlight + (weight * shine) * source.specular;
  }
  return s;
}

Shading ViewLight::shade(const Vec3& gradient, double value) const {
  return sum(gradient, value, [](const Source& source) -> const Source& { return source; });
}

Shading ViewLight::shade(const Vec3& gradient, double value, const Vec3& to_viewer) const {
  return sum(gradient, value, [&](Source source) {
    source.look_from(to_viewer);
    return source;
  });
}

} // namespace bccsplat
