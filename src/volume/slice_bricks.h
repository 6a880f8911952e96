// SPDX-License-Identifier: Apache-2.0
// A slice as bricks of equal size, as a host's own GPU draws from: values of the field on a Cartesian grid,
// or the coefficients of its sites, and which bricks hold more than the base of the field.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/context.h"
#include "points/values.h"
#include "volume/open_slice.h"

namespace bccsplat {

struct BrickSettings {
  bool sites = false; // of the lattice, each coset by itself; else samples of the field
  ValueType type = ValueType::f32;
  int edge = 32;      // samples along each axis that are a brick's own
  int border = 1;     // samples on each side that are others' too
  double spacing = 1; // of samples, slice units, at most
  Range range{};      // that the codes of integers span; no width: that of all values
};

// Where bricks stand, x fastest. Sample (i, j, k) of a coset is at origin + step * (i, j, k), slice space.
struct BrickGrid {
  int edge = 0, border = 0;
  int cosets = 1;
  Int3 dims{};   // samples of the first coset
  Int3 bricks{}; // per axis, of each coset
  std::array<Vec3, 2> origin{};
  Vec3 step{};
  double scale = 1, offset = 0; // value = offset + scale * what is stored

  [[nodiscard]] uint64_t cells() const { // of all cosets
    return static_cast<uint64_t>(bricks[0]) * bricks[1] * bricks[2] * cosets;
  }
  [[nodiscard]] int whole() const { return edge + 2 * border; }
  [[nodiscard]] uint64_t brick_samples() const { return static_cast<uint64_t>(whole()) * whole() * whole(); }
};

using ValueBounds = std::array<float, 2>;

// A slice with its bricks, which must outlive this.
class SliceBricks {
 public:
  // Fails with unsupported for sites of a slice whose values are not made of them, limit_exceeded for too
  // many samples.
  SliceBricks(const OpenSlice& slice, const BrickSettings& settings, const Context& context);

  [[nodiscard]] const BrickGrid& grid() const { return grid_; }
  // What bricks without data hold.
  [[nodiscard]] float empty() const { return slice_.slice.base; }
  // The radius of the slice's kernel, in steps of the sites.
  [[nodiscard]] double kernel_radius() const;
  // Returns for each brick bounds of its values, its border included; both are empty() where it holds nothing
  // else.
  [[nodiscard]] std::vector<ValueBounds> bounds(const Context& context) const;
  // Fills bricks, borders included, one behind the other, each x fastest. Beyond the last samples these go
  // on; what is missing is NaN, of integers what is empty. ranges: null, or the least and the largest value
  // of each that is there.
  void fill(std::span<const uint32_t> cells, void* values, ValueBounds* ranges, const Context& context) const;

 private:
  void lay_out_samples();
  void lay_out_sites();
  void set_codes(const Context& context);
  [[nodiscard]] std::array<Int3, 2> samples_of(uint64_t cell) const; // first and last, borders included
  [[nodiscard]] std::array<Vec3, 2> box_of(const std::array<Int3, 2>& samples) const; // slice space
  [[nodiscard]] ValueBounds bounds_of(uint64_t cell, std::vector<float>& scratch) const;
  void read(uint64_t cell, float* values, std::vector<float>& scratch, const Context& context) const;

  const OpenSlice& slice_;
  BrickSettings settings_;
  BrickGrid grid_;
};

} // namespace bccsplat
