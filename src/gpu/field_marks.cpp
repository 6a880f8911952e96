// SPDX-License-Identifier: Apache-2.0
#include "gpu/field_marks.h"

#include <cmath>

namespace bccsplat {
namespace {

constexpr int end_cells = 1; // before the first point of corrections

// scale * (coordinate of slice space) + offset, along each axis.
LatticeForms forms_of(const Slice& slice, const Vec3& scale, const Vec3& offset) {
  LatticeForms forms;
  for (size_t a = 0; a < 3; ++a) {
    Vec3 axis{};
    axis[a] = scale[a];
    forms.normal[a] = slice.lattice_to_slice.transposed(axis);
    forms.offset[a] = scale[a] * slice.lattice_to_slice.offset[a] + offset[a];
  }
  return forms;
}

void place_bricks(const SparseGrid& grid, FieldFixes& fixes) {
  grid.each([&](const Int3& at, float) {
    for (size_t a = 0; a < 3; ++a)
      fixes.bricks[a] = std::max(fixes.bricks[a], (at[a] + end_cells) / FieldFixes::brick_cells + 1);
  });
  fixes.brick_at.resize(static_cast<size_t>(fixes.bricks[0]) * fixes.bricks[1] * fixes.bricks[2]);
}

// Calls body(brick, point in it) for the bricks that a point is in: those of the cells at its sides.
template<class Body> void each_brick(const FieldFixes& fixes, const Int3& point, const Body& body) {
  constexpr int cells = FieldFixes::brick_cells;
  for (int corner = 0; corner < 8; ++corner) {
    Int3 brick, in;
    bool there = true;
    for (size_t a = 0; a < 3; ++a) {
      const int at = point[a] + end_cells;
      const bool as_last = corner >> a & 1; // of the brick before
      brick[a] = at / cells - (as_last ? 1 : 0), in[a] = at - cells * brick[a];
      there = there && brick[a] >= 0 && (!as_last || in[a] == cells);
    }
    if (!there) continue;
    body((static_cast<size_t>(brick[2]) * fixes.bricks[1] + brick[1]) * fixes.bricks[0] + brick[0],
         (static_cast<size_t>(in[2]) * FieldFixes::edge + in[1]) * FieldFixes::edge + in[0]);
  }
}

} // namespace

FieldFixes make_field_fixes(const Slice& slice) {
  FieldFixes fixes;
  if (!slice.corrections || slice.corrections->add.empty()) return fixes;
  const SparseGrid& grid = slice.corrections->add;
  constexpr double first = end_cells;
  fixes.to_cells = forms_of(slice, {1, 1, 1}, Vec3{first, first, first} - slice.corrections->origin);
  place_bricks(grid, fixes);
  uint32_t count = 1;
  grid.each([&](const Int3& at, float) {
    each_brick(fixes, at, [&](size_t brick, size_t) {
      if (fixes.brick_at[brick] == 0) fixes.brick_at[brick] = count++;
    });
  });
  constexpr size_t size = size_t{FieldFixes::edge} * FieldFixes::edge * FieldFixes::edge;
  fixes.value.resize(count * size);
  grid.each([&](const Int3& at, float value) {
    each_brick(fixes, at,
               [&](size_t brick, size_t in) { fixes.value[fixes.brick_at[brick] * size + in] = value; });
  });
  return fixes;
}

BitBox::BitBox(const Int3& of)
    : size(of), words(static_cast<size_t>(row_words()) * static_cast<size_t>(of[1] * of[2])) {}

MissingSamples make_missing_samples(const Slice& slice, const Context& context) {
  MissingSamples out;
  const auto grid = slice.mask ? slice.mask->grid() : std::nullopt;
  if (!grid) return out;
  out.to_samples = forms_of(slice, grid->scale, grid->offset);
  out.turning = grid->turning;
  out.bits = BitBox(grid->samples);
  context.tasks.parallel_for(static_cast<uint64_t>(grid->samples[2]), [&](uint64_t z) {
    context.progress.check();
    for (int y = 0; y < grid->samples[1]; ++y)
      for (int x = 0; x < grid->samples[0]; ++x)
        if (slice.mask->missing(grid->uvw({x, y, static_cast<int32_t>(z)})))
          out.bits.set(x, y, static_cast<int>(z));
  });
  return out;
}

} // namespace bccsplat
