// SPDX-License-Identifier: Apache-2.0
// Which cells of the plane grid (edge 1/sqrt2) of a slice on BCC may hold a value, proven: rays pass over the
// others. They depend on the slice and the value alone, so that they are kept while a camera moves.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/context.h"
#include "field/slice.h"

namespace bccsplat {

inline constexpr int block_edge = 4; // cells

// Blocks of 4^3 cells, x fastest, a bit for each cell: x + 4 y + 16 z.
struct SurfaceCells {
  Int3 cells{}, blocks{};
  std::vector<uint64_t> bits; // of a block
  Reservation memory;
  // Where cells are marked when rays come to them (cell_marker.h), the state of each stretch of a column, 8 x
  // 4 x 4 blocks; else empty, and all are marked.
  enum State : uint8_t { marked_some, waiting, empty };
  Int3 stretches{};
  std::vector<std::atomic<uint8_t>> state;

  [[nodiscard]] size_t stretch_at(const Int3& at) const {
    return (static_cast<size_t>(at[2]) * stretches[1] + at[1]) * stretches[0] + at[0];
  }
  // Whether a stretch has a mark.
  [[nodiscard]] bool any_marked(const Int3& stretch) const;
  [[nodiscard]] size_t at(const Int3& block) const {
    return (static_cast<size_t>(block[2]) * blocks[1] + block[1]) * blocks[0] + block[0];
  }
  // Returns the number of marks; those of a last block beyond the cells count, too.
  [[nodiscard]] uint64_t count() const;
  [[nodiscard]] bool marked(const Int3& cell) const {
    const uint64_t word = bits[at({cell[0] / block_edge, cell[1] / block_edge, cell[2] / block_edge})];
    return (word >> ((cell[0] & 3) + 4 * (cell[1] & 3) + 16 * (cell[2] & 3)) & 1) != 0;
  }
};

// Marks the cells in which the field may be `target`, relative to its base. The slice's kernel has a bound
// (cell_bound.h); where all coefficients in reach are 0 nothing is marked, for the field does not pass there.
// Throws memory_budget, cancelled.
[[nodiscard]] SurfaceCells mark_cells(const Slice& slice, double target, const Context& context);
// The same, or, where that is much for so many rays, with all cells waiting to be marked.
[[nodiscard]] SurfaceCells cells_for_rays(const Slice& slice, double target, uint64_t rays,
                                          const Context& context);
// Takes the marks off cells where a finer look at each proves that the field is not `target` there: twice the
// time of marking, a fourth of the samples less. Cut short by an error, it has done a part.
void refine_cells(const Slice& slice, double target, SurfaceCells& cells, const Context& context);
// Does so for the rows of blocks from `row` on that have at most `marks` marks together, moves `row` on to
// the next one, and returns how many marks it looked at. Rows of column after column; there are row_count().
uint64_t refine_rows(const Slice& slice, double target, SurfaceCells& cells, uint64_t& row, uint64_t marks,
                     const Context& context);
[[nodiscard]] uint64_t row_count(const SurfaceCells& cells);
// Marks all.
[[nodiscard]] SurfaceCells mark_all_cells(const Slice& slice, const Context& context);

// The cells of the last two surfaces, from picture to picture: of a draft by a coarser level and of the
// accurate picture after it, or of two values.
class KeptSurfaceCells {
 public:
  // The slices of earlier calls must be alive, or forget() have been called. rays: of the picture, by which
  // later ones refine as many rows of cells as takes a small part of what a picture takes.
  [[nodiscard]] std::shared_ptr<SurfaceCells> find(const Slice& slice, double target, const Context& context,
                                                   uint64_t rays = 0);
  void forget() { kept_ = {}; }

 private:
  struct Kept {
    const Slice* slice = nullptr;
    double target = 0;
    std::shared_ptr<SurfaceCells> cells;
    uint64_t rays = 0;    // that no row has been refined for yet
    uint64_t row = 0;     // the next one to refine
    uint64_t waiting = 0; // stretches, when refining began with the first row
  };
  std::array<Kept, 2> kept_; // the latest first
};

} // namespace bccsplat
