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
#include "field/scattered_field.h"
#include "points/sample_source.h"
#include "slice/plane_geometry.h"

namespace bccsplat {

class Extraction final : public ScatteredField {
 public:
  struct Point {
    std::array<float, 3> at; // along directions_, from origin_
    float weighted;          // sample relative to the base times exp(-2 d^2)
    float d2;
  };

  // `source` is a series of samples, on D4* or CC; `axes` are slice space, in the hyperplane. The points are
  // taken from the memory budget before they are made. lattice_to_slice: of the slice that it is the field
  // of.
  Extraction(const SampleSource& source, int channel, const Hyperplane& hyperplane, const PlaneAxes& axes,
             const Affine3& lattice_to_slice, const Context& context);
  // The same of no slice: the points of `at` and of sheets are of slice space.
  Extraction(const SampleSource& source, int channel, const Hyperplane& hyperplane, const PlaneAxes& axes,
             const Context& context)
      : Extraction(source, channel, hyperplane, axes, Affine3{}, context) {}

  // Tells what of the file such points are taken from. Throws unsupported where there are none.
  static void list_reads(const SampleSource& source, const Hyperplane& hyperplane, LayerReads& out);

  [[nodiscard]] uint64_t points() const { return points_.size(); }
  [[nodiscard]] std::array<double, 2> bounds() const; // no value lies outside
  [[nodiscard]] uint64_t bytes() const { return memory_.bytes(); }
  // Sets the field at points of slice space, and its gradients per unit of it unless there are none: the sum
  // of the splats, divided by that of a full lattice (closed form); NaN beyond the domain. Returns how many
  // points lie there.
  uint64_t sample(std::span<const Vec3> uvw, std::span<float> values,
                  std::span<std::array<float, 3>> gradients, const Context& context) const;
  void sample(const Grid& grid, float* values, const Context& context) const; // x fastest
  // Writes positions (slice space, 3 floats each) and weighted samples relative to air of the first
  // `capacity` points; either may be null. Returns how many points there are.
  uint64_t list(uint64_t capacity, float* uvw, float* weighted, Progress& progress) const;

  void at(std::span<const Vec3> points, std::span<float> values, std::span<Vec3> gradients) const override;
  [[nodiscard]] bool splat(const ScatterSheet& sheet) const override;
  void each_point(const std::function<void(const Vec3&, float, float)>& body) const override;

 private:
  using Found = std::vector<std::vector<Point>>; // by layer
  struct Splats;
  void set_axes(const Lattice4& lattice, const Affine3& lattice_to_slice);
  [[nodiscard]] Found collect(const SampleSource& source, int channel, const Hyperplane& h,
                              SharedReservation& memory, const Context& context);
  void sort_into_cells(const Found& found, const Context& context);
  [[nodiscard]] size_t cell(const std::array<float, 3>& at) const;
  [[nodiscard]] std::array<int, 2> cells_around(size_t axis, float low, float high) const;
  // Returns the value relative to the base at a point along the directions, and its gradient along them.
  [[nodiscard]] double value(const Vec3& at, Vec3* gradient) const;
  // Returns the sum of a full lattice's weights there.
  [[nodiscard]] double full_sum(const Vec3& at, Vec3* gradient) const;

  PlaneAxes axes_;
  Vec4 end_{};   // of the domain, index space
  Vec4 scale_{}; // index units -> lattice units
  Vec4 origin_{};
  std::array<Vec4, 3> directions_{}; // orthonormal in lattice units, in the hyperplane
  Affine3 along_;                    // slice space -> along the directions
  Affine3 of_lattice_;               // lattice units of the slice -> along the directions
  bool bcc_ = true;
  float air_ = 0, base_ = 0;
  std::array<float, 2> range_{0, 0}; // of the samples relative to the base, and 0
  std::vector<Point> points_;        // by cell
  std::vector<uint64_t> start_;
  std::array<float, 3> low_{};
  Int3 cells_{1, 1, 1};
  Reservation memory_;
};

} // namespace bccsplat
