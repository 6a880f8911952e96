// SPDX-License-Identifier: Apache-2.0
// Small fixed vectors and affine maps in double, which all geometry is decided in.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

namespace bccsplat {

using Vec3 = std::array<double, 3>;
using Vec4 = std::array<double, 4>;
using Int3 = std::array<int32_t, 3>;

[[nodiscard]] inline Vec3 operator+(const Vec3& a, const Vec3& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
[[nodiscard]] inline Vec3 operator-(const Vec3& a, const Vec3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
[[nodiscard]] inline Vec3 operator*(double s, const Vec3& a) { return {s * a[0], s * a[1], s * a[2]}; }
[[nodiscard]] inline double dot(const Vec3& a, const Vec3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
[[nodiscard]] inline Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
[[nodiscard]] inline double length(const Vec3& a) { return std::hypot(a[0], a[1], a[2]); }
[[nodiscard]] inline Vec3 normalized(const Vec3& a) { return (1 / length(a)) * a; }

// x -> linear * x + offset; linear is row-major.
struct Affine3 {
  std::array<Vec3, 3> linear{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
  Vec3 offset{};

  [[nodiscard]] Vec3 vector(const Vec3& v) const {
    return {dot(linear[0], v), dot(linear[1], v), dot(linear[2], v)};
  }
  [[nodiscard]] Vec3 point(const Vec3& p) const { return vector(p) + offset; }
  // linear^T * v: takes a covector (gradient) back through the map.
  [[nodiscard]] Vec3 transposed(const Vec3& v) const {
    return v[0] * linear[0] + (v[1] * linear[1] + v[2] * linear[2]);
  }
  [[nodiscard]] double determinant() const { return dot(linear[0], cross(linear[1], linear[2])); }
  [[nodiscard]] Affine3 inverse() const {
    const Vec3 c0 = cross(linear[1], linear[2]), c1 = cross(linear[2], linear[0]),
               c2 = cross(linear[0], linear[1]);
    const double s = 1 / determinant();
    Affine3 r;
    for (size_t i = 0; i < 3; ++i) r.linear[i] = {s * c0[i], s * c1[i], s * c2[i]};
    r.offset = -1.0 * r.vector(offset);
    return r;
  }
  // (*this)(inner(x))
  [[nodiscard]] Affine3 after(const Affine3& inner) const {
    Affine3 r;
    for (size_t i = 0; i < 3; ++i) r.linear[i] = inner.transposed(linear[i]);
    r.offset = point(inner.offset);
    return r;
  }
  bool operator==(const Affine3&) const = default;
};

// dot(normal, p) + offset >= 0 inside.
struct HalfSpace {
  Vec3 normal{};
  double offset = 0;

  bool operator==(const HalfSpace&) const = default;
  // The same half-space in the coordinates that `to_here` takes to these.
  [[nodiscard]] HalfSpace seen_through(const Affine3& to_here) const {
    return {to_here.transposed(normal), dot(normal, to_here.offset) + offset};
  }
};

} // namespace bccsplat
