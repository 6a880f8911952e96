// SPDX-License-Identifier: Apache-2.0
// Computes the length of each pixel's ray in the domain; background is the mean value that 2 % of the rays
// stay below, or air if that is more, white the integral above it that 0.2 % exceed. Rays that only graze the
// domain do not count for the background.
#include "tool/view/xray_exposure.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "tool/view/vectors.h"

namespace bcc4 {
namespace {

// Rays this much shorter than the longest, at the edges of the domain, say little of what is along them.
constexpr double kShortRay = 0.25;
// Shares of the rays: as dark as the darkest is the background, as bright as all but the brightest white.
constexpr double kDark = 0.02, kBright = 0.002;
// This share of white is drawn black, and from twice as much on nothing is changed.
constexpr double kToe = 1e-3;

// Rays of a camera, and the world lengths that they have inside of a slice's domain.
class RayLengths {
 public:
  RayLengths(const bccsplat_camera& c, const bccsplat_slice_info& slice, uint32_t width, uint32_t height)
      : slice_(slice), perspective_(c.projection == BCCSPLAT_PROJECTION_PERSPECTIVE), width_(width),
        height_(height) {
    Vector up;
    for (size_t i = 0; i < 3; ++i)
      position_[i] = c.position[i], forward_[i] = c.target[i] - c.position[i], up[i] = c.up[i];
    forward_ = normalised(forward_);
    right_ = normalised(cross(forward_, up));
    up_ = cross(right_, forward_);
    const double tall = perspective_ ? 2 * std::tan(c.fovy_degrees * std::numbers::pi / 360) : c.ortho_height;
    pixel_ = tall / height;
    invert(slice.affine);
  }

  [[nodiscard]] double length(uint32_t x, uint32_t y) const {
    const double across = (x + 0.5 - 0.5 * width_) * pixel_, upward = (0.5 * height_ - y - 0.5) * pixel_;
    Vector from = position_, direction = forward_;
    for (size_t i = 0; i < 3; ++i)
      (perspective_ ? direction : from)[i] += across * right_[i] + upward * up_[i];
    direction = normalised(direction);
    double enter = perspective_ ? 0 : -std::numeric_limits<double>::infinity();
    double leave = std::numeric_limits<double>::infinity();
    for (size_t a = 0; a < 3; ++a) {
      double start = inverse_[a][3], along = 0;
      for (size_t i = 0; i < 3; ++i)
        start += inverse_[a][i] * from[i], along += inverse_[a][i] * direction[i];
      if (std::fabs(along) < 1e-12) {
        if (start < slice_.extent[a][0] || start > slice_.extent[a][1]) return 0;
        continue;
      }
      const double one = (slice_.extent[a][0] - start) / along, other = (slice_.extent[a][1] - start) / along;
      enter = std::max(enter, std::min(one, other)), leave = std::min(leave, std::max(one, other));
    }
    return std::max(0.0, leave - enter);
  }

 private:
  void invert(const double (&m)[16]) {
    const auto at = [&](size_t r, size_t c) { return m[4 * (r % 3) + c % 3]; };
    double determinant = 0;
    for (size_t r = 0; r < 3; ++r)
      for (size_t c = 0; c < 3; ++c)
        inverse_[c][r] = at(r + 1, c + 1) * at(r + 2, c + 2) - at(r + 1, c + 2) * at(r + 2, c + 1);
    for (size_t c = 0; c < 3; ++c) determinant += at(0, c) * inverse_[c][0];
    for (auto& row : inverse_) {
      for (size_t c = 0; c < 3; ++c) row[c] /= determinant;
      row[3] = -(row[0] * m[3] + row[1] * m[7] + row[2] * m[11]);
    }
  }

  const bccsplat_slice_info& slice_;
  bool perspective_;
  double width_, height_, pixel_ = 1;
  Vector position_{}, forward_{}, right_{}, up_{};
  std::array<std::array<double, 4>, 3> inverse_{}; // world to slice space
};

double at_share(std::vector<double>& values, double share) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

} // namespace

double least_background(const bccsplat_look& look, double air) {
  const bool nothing_below = std::isinf(look.empty[0]) && air <= look.empty[1];
  const bool known = look.kind == BCCSPLAT_KIND_SOLID || look.kind == BCCSPLAT_KIND_FOG ||
                     look.kind == BCCSPLAT_KIND_CONSTANT || look.kind == BCCSPLAT_KIND_LABELS;
  return nothing_below && known ? air : -std::numeric_limits<double>::infinity();
}

void expose_xray(const bccsplat_frame* image, const bccsplat_camera& camera, const bccsplat_slice_info& slice,
                 double least, bool film, std::optional<XrayExposure>& exposure) {
  auto plane = sized<bccsplat_plane>();
  check(bccsplat_frame_get_channel(image, BCCSPLAT_FRAME_RGBA, &plane), "X-ray");
  const RayLengths rays(camera, slice, plane.width, plane.height);
  const auto pixel = [&](size_t n) {
    const size_t row = n / plane.width * (plane.row_bytes / sizeof(float));
    return plane.pixels + row + n % plane.width * plane.components;
  };
  const size_t count = size_t{plane.width} * plane.height;
  std::vector<double> lengths(count, 0.0);
  double longest = 0;
  for (size_t n = 0; n < count; ++n)
    if (pixel(n)[3] > 0) {
      lengths[n] =
          rays.length(static_cast<uint32_t>(n % plane.width), static_cast<uint32_t>(n / plane.width));
      longest = std::max(longest, lengths[n]);
    }
  const auto integral = [&](size_t n) { return static_cast<double>(pixel(n)[0]); };
  if (!exposure) {
    std::vector<double> densities, integrals;
    for (size_t n = 0; n < count; ++n)
      if (lengths[n] > kShortRay * longest) densities.push_back(integral(n) / lengths[n]);
    if (densities.empty()) return;
    exposure.emplace();
    const double dark = std::max(at_share(densities, kDark), least),
                 bright = at_share(densities, 1 - kBright);
    // A field that is the same everywhere has no background.
    if (bright - dark > 1e-3 * std::max(std::fabs(bright), std::fabs(dark))) exposure->background = dark;
    for (size_t n = 0; n < count; ++n)
      if (lengths[n] > 0) integrals.push_back(integral(n) - exposure->background * lengths[n]);
    exposure->white = at_share(integrals, 1 - kBright);
  }
  if (!(exposure->white > 0)) return;
  for (size_t n = 0; n < count; ++n) {
    const double v = (integral(n) - exposure->background * lengths[n]) / exposure->white;
    const double shown = std::max(0.0, std::min(v, 2 * (v - kToe)));
    for (size_t c = 0; c < 3; ++c) pixel(n)[c] = static_cast<float>(shown);
    if (film) pixel(n)[3] = 1;
  }
}

} // namespace bcc4
