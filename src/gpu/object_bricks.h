// SPDX-License-Identifier: Apache-2.0
// The bricks and cells of several objects side by side, so that one shader finds those of each.
#pragma once

#include <cstdint>
#include <vector>

#include "gpu/field_bricks.h"

namespace bccsplat {

// Where an object's own stand among those of all.
struct ObjectPlace {
  Int3 bricks{}, cells{};
  uint32_t first = 0; // brick
};

struct ObjectBricks {
  std::vector<ObjectPlace> places;
  FieldBricks all;  // brick_at of one coset and cells, without ranges; no values
  size_t count = 0; // bricks
};

// counts: bricks of each object, its brick 0 included. All have one edge.
[[nodiscard]] ObjectBricks place_objects(const std::vector<const FieldBricks*>& objects,
                                         const std::vector<size_t>& counts);

// Puts what is known of an object's cells among that of all.
void place_cells(const ObjectBricks& objects, size_t n, const Int3& cells, const std::vector<uint8_t>& from,
                 std::vector<uint8_t>& all);

} // namespace bccsplat
