// SPDX-License-Identifier: Apache-2.0
// A dense box of floats, x fastest, and trilinear interpolation in it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace smoke {

struct Vec3 {
  float x, y, z;
};
inline Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator*(float s, Vec3 a) { return {s * a.x, s * a.y, s * a.z}; }

struct Grid {
  int nx, ny, nz;
  std::vector<float> samples;

  Grid(int x, int y, int z) : nx(x), ny(y), nz(z), samples(static_cast<size_t>(x) * y * z) {}

  [[nodiscard]] size_t index(int i, int j, int k) const { return (static_cast<size_t>(k) * ny + j) * nx + i; }
  float& operator()(int i, int j, int k) { return samples[index(i, j, k)]; }
  const float& operator()(int i, int j, int k) const { return samples[index(i, j, k)]; }
};

// The eight samples around a point and the weights between them.
struct Corner {
  size_t at;        // sample of the lowest corner
  size_t dy, dz;    // to the next row and plane
  float fx, fy, fz; // in [0, 1]
};

// p is in sample indices; points outside are moved to the border.
inline Corner corner(const Grid& grid, Vec3 p) {
  const float x = std::clamp(p.x, 0.0f, static_cast<float>(grid.nx - 1));
  const float y = std::clamp(p.y, 0.0f, static_cast<float>(grid.ny - 1));
  const float z = std::clamp(p.z, 0.0f, static_cast<float>(grid.nz - 1));
  const int i = std::min(static_cast<int>(x), grid.nx - 2);
  const int j = std::min(static_cast<int>(y), grid.ny - 2);
  const int k = std::min(static_cast<int>(z), grid.nz - 2);
  const size_t row = grid.nx;
  return {grid.index(i, j, k),      row, row * grid.ny, x - static_cast<float>(i), y - static_cast<float>(j),
          z - static_cast<float>(k)};
}

inline float interpolate(const Grid& grid, const Corner& c) {
  const float* s = grid.samples.data() + c.at;
  const auto line = [&](size_t o) { return s[o] + c.fx * (s[o + 1] - s[o]); };
  const float y0 = line(0) + c.fy * (line(c.dy) - line(0));
  const float y1 = line(c.dz) + c.fy * (line(c.dz + c.dy) - line(c.dz));
  return y0 + c.fz * (y1 - y0);
}

inline float interpolate(const Grid& grid, Vec3 p) { return interpolate(grid, corner(grid, p)); }

} // namespace smoke
