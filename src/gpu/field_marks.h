// SPDX-License-Identifier: Apache-2.0
// Corrections of a slice's field, and which of its samples and sites are missing, as a GPU looks them up.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "base/context.h"
#include "field/slice.h"

namespace bccsplat {

// Numbers that are linear in lattice units: normal * p + offset along each of three axes.
struct LatticeForms {
  std::array<Vec3, 3> normal{};
  Vec3 offset{};
};

// Corrections in bricks of 16^3 cells of their grid, with the points at both ends of each cell. The first
// cell lies before the first point.
struct FieldFixes {
  static constexpr int brick_cells = 16, edge = brick_cells + 1;
  LatticeForms to_cells;
  Int3 bricks{};
  std::vector<uint32_t> brick_at; // z, y, x: 0 where there are none, else which brick; brick 0 is zeros
  std::vector<float> value;       // brick after brick, x fastest
  [[nodiscard]] bool empty() const { return brick_at.empty(); }
  static constexpr size_t brick_values = size_t{edge} * edge * edge;
  [[nodiscard]] size_t count() const { return value.size() / brick_values; }
};
[[nodiscard]] FieldFixes make_field_fixes(const Slice& slice);

// A bit for each place of a box: words of 32 along x.
struct BitBox {
  static constexpr int word_bits = 32;
  Int3 size{}; // places
  std::vector<uint32_t> words;
  explicit BitBox(const Int3& of = {});
  [[nodiscard]] int row_words() const { return (size[0] + word_bits - 1) / word_bits; }
  [[nodiscard]] size_t word(int x, int y, int z) const {
    return (static_cast<size_t>(z) * size[1] + y) * row_words() + x / word_bits;
  }
  void set(int x, int y, int z) { words[word(x, y, z)] |= 1u << (x % word_bits); }
  [[nodiscard]] bool at(int x, int y, int z) const { return words[word(x, y, z)] >> (x % word_bits) & 1; }
  [[nodiscard]] bool empty() const { return words.empty(); }
};

// Which source samples are missing. A point has no value whose nearest one is.
struct MissingSamples {
  LatticeForms to_samples;
  AxisFlags turning{}; // axes along which behind the last sample comes the first
  BitBox bits;
};
// The slice's mask has a grid (field/slice_mask.h). Throws cancelled.
[[nodiscard]] MissingSamples make_missing_samples(const Slice& slice, const Context& context);

} // namespace bccsplat
