// SPDX-License-Identifier: Apache-2.0
#include "formats/bcc4/coding/restore_cells.h"

#include <algorithm>
#include <bit>
#include <cstring>

namespace bccsplat {
namespace {

// Fills the cells of one layer and of its border.
template<class Stored>
void restore_layer(const BrickMask& rows, const Int3& box, uint32_t air, const std::byte* packed,
                   int32_t* layer, Planes& used) {
  const auto next_cell = [&] {
    Stored code;
    std::memcpy(&code, packed, sizeof code);
    packed += sizeof code;
    return static_cast<int32_t>(code - air);
  };
  for (int z = 0; z < box[2]; ++z) {
    if (plane_empty(rows, z)) continue;
    used |= plane_bit(z);
    for (int y = 0; y < box[1]; ++y) {
      int32_t* const own = layer + (z + 1) * stride_z + (y + 1) * stride_y + 1;
      const unsigned here = rows[z * brick_edge + y];
      for (int x = 0; x < box[0]; ++x)
        if (here >> x & 1) own[x] = next_cell();
      own[box[0]] = own[box[0] - 1];
    }
  }
  close_layer(layer, rows, box, used);
}

} // namespace

void restore_cells(const ChunkShape& shape, std::span<const BrickMask> kept, const ChunkCodes& codes,
                   int next, const LayersBefore& before, CellRing<int32_t>& ring) {
  for (int m = std::max(0, next - 2); m < next; ++m) {
    int32_t* const layer = ring.clear(m);
    if (shape.empty(m)) continue;
    const size_t i = m;
    const std::byte* const packed = before[m - next + 2].data();
    if (codes.bytes() == 1)
      restore_layer<uint8_t>(kept[i], shape.box[i], codes.air, packed, layer, ring.used[i % 3]);
    else
      restore_layer<uint16_t>(kept[i], shape.box[i], codes.air, packed, layer, ring.used[i % 3]);
  }
}

} // namespace bccsplat
