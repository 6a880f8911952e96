// SPDX-License-Identifier: Apache-2.0
// The paper's extraction, for comparison: every 4D lattice point within reach of the hyperplane is projected
// onto it and splatted there with the 3D Gaussian, weighted by the part of the 4D Gaussian that its distance
// leaves: exp(-2 |p - q|^2) = exp(-2 d^2) exp(-2 r^2). Source: Neophytou & Mueller, Space-time points: 4D
// splatting on efficient grids (2002), section 4. It needs no lattice in the hyperplane and no prefilter, and
// yields several times the points of one.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/context.h"
#include "field/sample_grid.h"
#include "points/sample_source.h"
#include "slice/plane_geometry.h"

namespace bccsplat {

class Extraction {
 public:
  // `source` is a D4* volume that holds samples; `axes` are slice space, in the hyperplane.
  Extraction(const SampleSource& source, int channel, const Hyperplane& hyperplane, const PlaneAxes& axes,
             const Context& context);

  [[nodiscard]] uint64_t points() const { return points_.size(); }
  [[nodiscard]] std::array<double, 2> bounds() const; // no value lies outside
  [[nodiscard]] uint64_t bytes() const { return points_.size() * sizeof(Point); }
  // Sets the field at points of slice space: the sum of the splats, divided by that of a full lattice (closed
  // form); NaN beyond the domain. Returns how many points lie there.
  uint64_t sample(std::span<const Vec3> uvw, std::span<float> values, const Context& context) const;
  void sample(const Grid& grid, float* values, const Context& context) const; // x fastest
  // Writes positions (slice space, 3 floats each) and weighted samples relative to air of the first
  // `capacity` points; either may be null. Returns how many points there are.
  uint64_t list(uint64_t capacity, float* uvw, float* weighted, Progress& progress) const;

 private:
  struct Point {
    std::array<float, 3> at; // along directions_, from origin_
    float weighted;          // sample relative to the base times exp(-2 d^2)
    float d2;
  };
  [[nodiscard]] size_t cell(const std::array<float, 3>& at) const;
  [[nodiscard]] float value(const Vec4& lattice_point) const;

  PlaneAxes axes_;
  Vec4 end_{};   // of the domain, index space
  Vec4 scale_{}; // index units -> lattice units
  Vec4 origin_{};
  std::array<Vec4, 3> directions_{}; // orthonormal in lattice units, in the hyperplane
  float air_ = 0, base_ = 0;
  std::array<float, 2> range_{0, 0}; // of the samples relative to the base, and 0
  std::vector<Point> points_;        // by cell
  std::vector<uint64_t> start_;
  std::array<float, 3> low_{};
  Int3 cells_{1, 1, 1};
};

} // namespace bccsplat
