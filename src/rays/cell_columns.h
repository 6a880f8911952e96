// SPDX-License-Identifier: Apache-2.0
// The columns of 16 x 16 cells along x that cells are marked in, and the coefficients that each depends on.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/context.h"
#include "base/pool.h"
#include "field/slice.h"
#include "rays/cell_column.h"
#include "rays/surface_cells.h"

namespace bccsplat {

inline constexpr int column_blocks = column_edge / block_edge;        // across
inline constexpr int stretch_blocks = 2 * stretch_lanes / block_edge; // along

// The columns of a slice's cells; both must outlive it. Used by several threads at a time.
class CellColumns {
 public:
  CellColumns(const Slice& slice, const Int3& cells, const Context& context);

  // Columns along y and z, and the stretches of one along x.
  [[nodiscard]] const Int3& count() const { return count_; }
  [[nodiscard]] const ColumnSites& shape() const { return shape_; }

  // What the columns of one thread work in.
  struct Memory {
    Reservation memory;
    ColumnSites sites;
    std::vector<uint8_t> stretches; // that have a brick in reach, of those asked for, and two that have none
  };
  // Calls body(memory) with the coefficients of the column at (y, z) in reach of stretches first .. last,
  // unless these have none.
  template<class Body> void read(int y, int z, int first, int last, const Body& body) {
    std::unique_ptr<Memory> memory = memories_.take([this] { return make_memory(); });
    if (fill(y, z, first, last, *memory)) body(*memory);
    memories_.give_back(std::move(memory));
  }

 private:
  using Rows = std::array<std::array<std::array<int, column_sites>, 2>, 2>; // sites, by coset and axis
  [[nodiscard]] Rows rows_of(int y, int z) const;
  void find_present(const Rows& rows, std::vector<uint8_t>& present) const;
  bool fill(int y, int z, int first, int last, Memory& memory) const;
  void read_row(size_t c, int j, int k, float* to, std::span<const uint8_t> filled, size_t first) const;
  [[nodiscard]] std::unique_ptr<Memory> make_memory() const;

  const Slice& slice_;
  Context context_;
  ColumnSites shape_; // without memory
  Int3 count_{};
  std::array<std::vector<std::array<int, 2>>, 2> ends_; // by coset: sites beyond the ends, and their mirrors
  Pool<Memory> memories_;
};

} // namespace bccsplat
