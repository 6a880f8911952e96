// SPDX-License-Identifier: Apache-2.0
// What a slice of some thickness holds of the field.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "base/context.h"
#include "field/coefficients/coefficients.h"
#include "field/hyperplane.h"
#include "slice/thickness.h"

namespace bccsplat {

// Values at points of the hyperplane, relative to the slice's base: those of the field, or what it holds
// along the normal over a thickness.
class ThickField {
 public:
  // The coefficients must outlive it. bandwidth: values are those of equation (6), of the samples behind the
  // coefficients (gaussian_mean.h), without a thickness.
  ThickField(const Coefficients& coefficients, const Hyperplane& h, const Thickness& thickness,
             const std::optional<Vec4>& bandwidth = {});
  [[nodiscard]] float base() const { return along_normal(coefficients_.base()); }
  [[nodiscard]] float air() const { return along_normal(coefficients_.air()); }
  // Returns about what a point takes while values() runs: itself and its place, value and hole; order and
  // keys (point_order.cpp); of thick slices its line and sums.
  [[nodiscard]] uint64_t bytes_per_point() const { return nodes_.node.empty() ? 68 : 160; }
  // Points may be anywhere near the domain; `holes` becomes 1 where the nearest site is a hole.
  void values(std::span<const Vec4> points, std::span<float> out, std::span<uint8_t> holes,
              const Context& context) const;

 private:
  [[nodiscard]] std::array<double, 2> clip(Vec4& p) const;
  // Returns what a slice holds of a constant field.
  [[nodiscard]] float along_normal(float value) const {
    return thickness_.kind == ThicknessKind::sum && thickness_.length > 0
               ? static_cast<float>(value * thickness_.length)
               : value;
  }

  const Coefficients& coefficients_;
  Vec4 normal_, end_{};
  Thickness thickness_;
  Quadrature nodes_;
  std::optional<Vec4> bandwidth_;
};

} // namespace bccsplat
