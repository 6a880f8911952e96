// SPDX-License-Identifier: Apache-2.0
// Marks the cells of a surface, all at once or where rays come: what lies behind the surface never is.
#pragma once

#include <array>
#include <atomic>
#include <mutex>

#include "rays/cell_bound.h"
#include "rays/cell_columns.h"

namespace bccsplat {

// The half bounds that ranges are widened by, rounding of floats included.
[[nodiscard]] CellBound margins_of(const Slice& slice, int parts);

// Cells without any mark.
[[nodiscard]] SurfaceCells unmarked_cells(const Slice& slice, const Context& context);

class CellMarker {
 public:
  // The cells are the slice's; both must outlive it.
  CellMarker(const Slice& slice, double target, SurfaceCells& cells, const Context& context);

  void mark_all();
  // Returns about how many blocks there are in stretches that may hold the target, by a part of the columns.
  [[nodiscard]] uint64_t blocks_to_mark();
  // Has all these stretches wait.
  void let_wait();
  // Marks the stretches of the blocks begin .. end - 1 that wait, where let_wait() was; returns false
  // where none of the stretches has a mark. For several threads at a time.
  [[nodiscard]] bool need(const Int3& begin, const Int3& end);

 private:
  template<class Body> void each_column(uint64_t step, const Body& body);
  [[nodiscard]] ColumnArgs column_args(CellColumns::Memory& memory, int y, int z);
  void mark_waiting(const Int3& at, std::atomic<uint8_t>& state);

  SurfaceCells& cells_;
  Context context_;
  CellColumns columns_;
  CornerStencils stencils_;
  ColumnArgs args_;
  std::array<std::mutex, 64> marking_; // by stretch
};

} // namespace bccsplat
