// SPDX-License-Identifier: Apache-2.0
// Visits rows of sites in coding order, with the cells they are predicted from (bcc4.md, section 7).
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>

#include "formats/bcc4/coding/chunk.h"

namespace bccsplat {

// A layer of cells has a border of one: cell (x, y, z) is code minus air, x fastest, 0 where not kept. The
// half row of room behind the last site of a row has no meaning.
inline constexpr int stride_y = 24, stride_z = 18 * stride_y, layer_cells = 18 * stride_z;
inline constexpr int fraction_bits = 12;     // of weights
inline constexpr unsigned full_row = 0xffff; // sites kept

inline constexpr int own_taps = 10, cross_taps = 8, previous_taps = 7,
                     max_taps = own_taps + cross_taps + previous_taps;
inline constexpr std::array<int, own_taps> own_offset = {-1,
                                                         -stride_y,
                                                         -stride_z,
                                                         -1 - stride_y,
                                                         -1 - stride_z,
                                                         -stride_y - stride_z,
                                                         -1 - stride_y - stride_z,
                                                         1 - stride_y,
                                                         1 - stride_z,
                                                         stride_y - stride_z};
inline constexpr std::array<int, previous_taps> previous_offset = {0,        -1,        1,       -stride_y,
                                                                   stride_y, -stride_z, stride_z};

// The offset of a neighbour in the cross layer from the lowest of the 8.
[[nodiscard]] constexpr int cross_offset(int tap) {
  return (tap & 1) + (tap >> 1 & 1) * stride_y + (tap >> 2) * stride_z;
}

// Neighbours that exist decide which weights a layer uses: bit 0 cross, bit 1 previous.
inline constexpr int classes = 4;
[[nodiscard]] inline int layer_class(const ChunkShape& shape, int layer) {
  return (shape.has_cross(layer) ? 1 : 0) | (shape.has_previous(layer) ? 2 : 0);
}
[[nodiscard]] inline int class_taps(int c) {
  return own_taps + (c & 1 ? cross_taps : 0) + (c & 2 ? previous_taps : 0);
}

[[nodiscard]] inline unsigned classes_present(const ChunkShape& shape) {
  unsigned present = 0;
  for (int m = 0; m < shape.layers; ++m)
    if (!shape.empty(m)) present |= 1u << layer_class(shape, m);
  return present;
}

// Weights of one class in tap order: own, cross, previous; taps a class lacks are left out.
using Weights = std::array<int16_t, max_taps>;
using ClassWeights = std::array<Weights, classes>;

// The cells that a row of sites is predicted from; each pointer is at the cell of the first site.
template<class D> struct Row {
  int layer, index, width; // index = z*16 + y
  D* own;
  const D* cross; // at the lowest of the 8 neighbours; null: none
  const D* previous;
};

// Planes of a layer, by bit: plane z at bit z + 1.
using Planes = uint32_t;
inline constexpr Planes all_planes = (Planes{1} << 18) - 1;
[[nodiscard]] constexpr Planes plane_bit(int z) { return Planes{1} << (z + 1); }

// Copies the cells around the sites of a layer from the layer before, of which only `planes` are not all 0.
template<class D> void copy_border(D* to, const D* from, const Int3& n, Planes planes) {
  const auto [nx, ny, nz] = n;
  const auto copy = [&](std::ptrdiff_t at, int count) { std::copy_n(from + at, count, to + at); };
  if (planes & plane_bit(-1)) copy(0, stride_z);
  if (planes & plane_bit(nz)) copy((nz + 1) * stride_z, stride_z);
  for (int z = 1; z <= nz; ++z) {
    if (!(planes & plane_bit(z - 1))) continue;
    copy(z * stride_z, stride_y);
    copy(z * stride_z + (ny + 1) * stride_y, stride_y);
    for (int y = 1; y <= ny; ++y) {
      copy(z * stride_z + y * stride_y, 1);
      copy(z * stride_z + y * stride_y + nx + 1, 1);
    }
  }
}

// Returns whether no site of plane z is kept.
[[nodiscard]] inline bool plane_empty(const BrickMask& kept, int z) {
  std::array<uint64_t, brick_edge / 4> rows;
  std::memcpy(rows.data(), kept.data() + z * brick_edge, sizeof rows);
  return (rows[0] | rows[1] | rows[2] | rows[3]) == 0;
}

// The cells of three layers and, by bit, those planes of them that may hold other than 0. One ring serves any
// number of walks.
template<class D> struct CellRing {
  std::unique_ptr<D[]> cells;
  std::array<Planes, 3> used{all_planes, all_planes, all_planes};

  // The cells of a layer of a chunk.
  [[nodiscard]] D* layer(int m) { return cells.get() + (m % 3) * layer_cells; }
  // Makes them all 0.
  D* clear(int m) {
    if (!cells) {
      cells = std::make_unique_for_overwrite<D[]>(3 * layer_cells + brick_edge);
      std::fill_n(cells.get() + 3 * layer_cells, brick_edge, D{0});
    }
    Planes& left = used[m % 3];
    while (left != 0) { // run by run
      const int first = std::countr_zero(left), count = std::countr_one(left >> first);
      std::memset(layer(m) + first * stride_z, 0, count * stride_z * sizeof(D));
      left &= ~Planes{0} << first << count;
    }
    return layer(m);
  }
};

// Returns whether all of `width` sites of `height` rows of plane z are.
[[nodiscard]] inline bool plane_full(const BrickMask& kept, int z, int width, int height) {
  const auto rows = std::span(kept).subspan(static_cast<size_t>(z) * brick_edge, height);
  return std::all_of(rows.begin(), rows.end(), [&](uint16_t row) { return row == (1u << width) - 1; });
}

// Makes the border of a filled layer: each of its cells repeats the nearest one of the box.
template<class D> void close_layer(D* layer, const BrickMask& rows, const Int3& box, Planes& used) {
  const auto copy_row = [](D* to, const D* from) { std::copy_n(from, stride_y, to); };
  for (int z = 0; z < box[2]; ++z) {
    if (!(used & plane_bit(z))) continue;
    D* const plane = layer + (z + 1) * stride_z;
    for (int y = 0; y < box[1]; ++y) plane[(y + 1) * stride_y] = plane[(y + 1) * stride_y + 1];
    copy_row(plane, plane + stride_y);
    copy_row(plane + (box[1] + 1) * stride_y, plane + box[1] * stride_y);
    if (plane_empty(rows, z)) used &= ~plane_bit(z); // only its border was not 0
  }
  const auto repeat = [&](int to, int from) {
    D* const plane = layer + (to + 1) * stride_z;
    if (used & plane_bit(from)) {
      std::copy_n(layer + (from + 1) * stride_z, stride_z, plane);
      used |= plane_bit(to);
    } else if (used & plane_bit(to)) {
      std::fill_n(plane, stride_z, D{0});
      used &= ~plane_bit(to);
    }
  };
  repeat(-1, 0);
  repeat(box[2], box[2] - 1);
}

// Layers of a chunk that are visited, and how many codes those before them have.
struct WalkedLayers {
  int first = 0, end = max_slab_layers;
  size_t codes_before = 0;
};

// Visits the rows of a chunk that have kept sites, in coding order, and keeps the borders. While a layer is
// being filled its border is that of the layer before, or, where there is none, repeats what is known so far;
// afterwards it repeats the nearest cell. `kept` has one mask per layer. `body` fills the sites of a row.
// `pair` may fill those of two rows at once and returns whether it did; its last argument says whether the
// cell before the second row is to repeat the first site of the first row, else that cell is already in
// place. The cell behind the first row repeats its last site. `plane` may likewise fill a plane whose sites
// are all kept, from its first row on, as many as its second argument says, with the cells before and behind
// them. From a later layer than the first on, the ring must have the cells of the two before it.
template<class D, class Body, class Pair, class Plane>
void walk_rows(const ChunkShape& shape, std::span<const BrickMask> kept, CellRing<D>& ring, const Body& body,
               const Pair& pair, const Plane& whole_plane, const WalkedLayers& layers = {}) {
  const auto copy_row = [](D* to, const D* from) { std::copy_n(from, stride_y, to); };
  for (int m = layers.first; m < std::min(shape.layers, layers.end); ++m) {
    D* const layer = ring.clear(m);
    Planes& used = ring.used[m % 3];
    if (shape.empty(m)) continue;
    const Int3& box = shape.box[m];
    const int nx = box[0], ny = box[1], nz = box[2]; // clang 14 captures no structured bindings
    const D* previous = shape.has_previous(m) ? ring.layer(m - shape.period) : nullptr;
    const D* cross = shape.has_cross(m) ? ring.layer(m - 1) : nullptr;
    const D* before = previous ? previous : cross;
    if (before) {
      used = ring.used[(previous ? m - shape.period : m - 1) % 3];
      copy_border(layer, before, box, used);
    }
    const BrickMask& rows = kept[m];
    const std::ptrdiff_t lowest = shape.coset(m) == 1 ? 0 : -1 - stride_y - stride_z;
    for (int z = 0; z < nz; ++z) {
      D* const plane = layer + (z + 1) * stride_z;
      if (!before && z > 0 && used & plane_bit(z - 1)) {
        copy_row(plane, plane - stride_z + stride_y);
        used |= plane_bit(z);
      }
      const bool empty = plane_empty(rows, z);
      if (!empty) used |= plane_bit(z);
      if (!(used & plane_bit(z))) continue;
      const auto row_at = [&](int y) {
        D* const own = plane + (y + 1) * stride_y + 1;
        const std::ptrdiff_t at = own - layer;
        return Row<D>{m,
                      z * brick_edge + y,
                      nx,
                      own,
                      cross ? cross + at + lowest : nullptr,
                      previous ? previous + at : nullptr};
      };
      const bool done = plane_full(rows, z, nx, ny) && whole_plane(row_at(0), ny, !before);
      for (int y = 0; y < ny && !done; ++y) {
        if (empty || rows[z * brick_edge + y] == 0) {
          D* const own = plane + (y + 1) * stride_y + 1;
          if (!before) own[-1] = own[-stride_y];
          own[nx] = own[nx - 1];
          continue;
        }
        const Row<D> row = row_at(y);
        if (!before) row.own[-1] = row.own[-stride_y];
        if (y + 1 < ny && pair(row, row_at(y + 1), !before)) {
          row.own[nx] = row.own[nx - 1];
          D* const second = row.own + stride_y;
          if (!before) second[-1] = row.own[0];
          second[nx] = second[nx - 1];
          ++y;
          continue;
        }
        body(row);
        row.own[nx] = row.own[nx - 1];
      }
      copy_row(plane + (ny + 1) * stride_y, plane + ny * stride_y);
    }
    close_layer(layer, rows, box, used);
  }
}

template<class D, class Body>
void walk_rows(const ChunkShape& shape, std::span<const BrickMask> kept, CellRing<D>& ring,
               const Body& body) {
  walk_rows<D>(
      shape, kept, ring, body, [](const Row<D>&, const Row<D>&, bool) { return false; },
      [](const Row<D>&, int, bool) { return false; });
}

// Collects the taps of a class in order, as pointers to the cells of the first site of the row.
template<class D> size_t gather_taps(const Row<D>& row, std::array<const D*, max_taps>& taps) {
  size_t n = 0;
  for (const int o : own_offset) taps[n++] = row.own + o;
  if (row.cross)
    for (int i = 0; i < cross_taps; ++i) taps[n++] = row.cross + cross_offset(i);
  if (row.previous)
    for (const int o : previous_offset) taps[n++] = row.previous + o;
  return n;
}

} // namespace bccsplat
