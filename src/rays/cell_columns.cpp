// SPDX-License-Identifier: Apache-2.0
// Rows of coefficients are copied from bricks; stretches are as long as these. What is read of a stretch
// reaches into those beside it.
#include "rays/cell_columns.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace bccsplat {
namespace {

constexpr int beyond = 4; // sites that stretches look at

// Marks the stretches that a brick of the column's rows is in.
void find_bricks(const BrickLayer& layer, const std::array<std::array<int, column_sites>, 2>& at,
                 std::vector<uint8_t>& present) {
  int last = -1;
  for (const int k : at[1])
    for (const int j : at[0]) {
      const int place = k / brick_edge * layer.brick_dims()[1] + j / brick_edge;
      if (place == last) continue;
      last = place;
      const size_t slot = layer.slot(0, j / brick_edge, k / brick_edge);
      for (size_t b = 0; b < layer.row_slots(); ++b)
        if (layer.brick(slot + b)) present[b] = 1;
    }
}

// Marks what is beside the stretches that are marked, too.
void spread(std::vector<uint8_t>& stretches) {
  uint8_t before = 0;
  for (size_t s = 0; s < stretches.size(); ++s) {
    const uint8_t here = stretches[s];
    const uint8_t behind = s + 1 < stretches.size() ? stretches[s + 1] : uint8_t{0};
    stretches[s] = before | here | behind;
    before = here;
  }
}

} // namespace

CellColumns::CellColumns(const Slice& slice, const Int3& cells, const Context& context)
    : slice_(slice), context_(context) {
  const int lanes = cells[0] / 2 + 1;
  shape_.set_size((lanes + stretch_lanes - 1) / stretch_lanes);
  count_ = {shape_.stretches, (cells[1] + column_edge - 1) / column_edge,
            (cells[2] + column_edge - 1) / column_edge};
  for (size_t c = 0; c < 2; ++c) {
    const int count = slice.coset[c].dims()[0];
    for (int i = 1; i <= beyond; ++i) {
      ends_[c].push_back({-i, slice.lattice.mirror(0, static_cast<int>(c), -i)});
      ends_[c].push_back({count - 1 + i, slice.lattice.mirror(0, static_cast<int>(c), count - 1 + i)});
    }
  }
}

CellColumns::Rows CellColumns::rows_of(int y, int z) const {
  Rows rows;
  for (int c = 0; c < 2; ++c)
    for (int v = 0; v < column_sites; ++v) {
      rows[c][0][v] = slice_.lattice.mirror(1, c, column_edge / 2 * y - 1 + v);
      rows[c][1][v] = slice_.lattice.mirror(2, c, column_edge / 2 * z - 1 + v);
    }
  return rows;
}

void CellColumns::find_present(const Rows& rows, std::vector<uint8_t>& present) const {
  present.assign(static_cast<size_t>(shape_.stretches) + 2, 0);
  for (size_t c = 0; c < 2; ++c) find_bricks(slice_.coset[c], rows[c], present);
  spread(present);
}

bool CellColumns::fill(int y, int z, int first, int last, Memory& memory) const {
  const Rows rows = rows_of(y, z);
  std::vector<uint8_t>& present = memory.stretches;
  find_present(rows, present);
  std::fill(present.begin(), present.begin() + first, uint8_t{0});
  std::fill(present.begin() + last + 1, present.end(), uint8_t{0});
  if (std::find(present.begin(), present.end(), 1) == present.end()) return false;
  std::vector<uint8_t> filled = present;
  spread(filled);
  const auto begin = std::find(filled.begin(), filled.end(), 1),
             end = std::find(filled.rbegin(), filled.rend(), 1).base();
  const std::span<const uint8_t> part(begin, end);
  for (size_t c = 0; c < 2; ++c)
    for (int w = 0; w < column_sites; ++w)
      for (int v = 0; v < column_sites; ++v)
        read_row(c, rows[c][0][v], rows[c][1][w], memory.sites.value.data() + memory.sites.at(c, v, w), part,
                 begin - filled.begin());
  return true;
}

void CellColumns::read_row(size_t c, int j, int k, float* to, std::span<const uint8_t> filled,
                           size_t first) const {
  const BrickLayer& layer = slice_.coset[c];
  const size_t slot = layer.slot(0, j / brick_edge, k / brick_edge),
               from = (k % brick_edge * brick_edge + j % brick_edge) * brick_edge;
  const size_t end = std::min(first + filled.size(), layer.row_slots());
  for (size_t b = first; b < end; ++b) {
    if (filled[b - first] == 0) continue;
    float* const part = to + static_cast<std::ptrdiff_t>(b) * brick_edge;
    if (const Brick* const brick = layer.brick(slot + b))
      std::memcpy(part, brick->value.data() + from, brick_edge * sizeof(float));
    else
      std::memset(part, 0, brick_edge * sizeof(float));
  }
  for (const auto& [beyond_end, inside] : ends_[c]) to[beyond_end] = to[inside];
}

std::unique_ptr<CellColumns::Memory> CellColumns::make_memory() const {
  auto memory = std::make_unique<Memory>();
  memory->memory = Reservation(context_.memory, 3 * shape_.floats() * sizeof(float), "a surface's corners");
  memory->sites.prepare(shape_.stretches);
  return memory;
}

} // namespace bccsplat
