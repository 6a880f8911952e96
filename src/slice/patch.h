// The sites of one coset around a point, and where the bricks keep them.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "base/vec.h"
#include "points/brick.h"

namespace bccsplat {

// No kernel reaches further than two pitches: at most 4 sites of a coset per axis lie strictly within.
inline constexpr int patch_edge = 4;
inline constexpr int patch_rows = patch_edge * patch_edge;
inline constexpr int patch_sites = patch_edge * patch_rows;

// The values of a brick that is not there.
[[nodiscard]] const float* air_brick();

// Distance of neighbouring sites of a coset in lattice units.
[[nodiscard]] inline double coset_pitch(const Lattice3& lattice) {
  return lattice.bcc ? 2 * lattice.plane_distance() : lattice.plane_distance();
}

// First and last site of a coset, per axis, strictly within the kernel's radius; may lie beyond the ends.
struct PatchSpan {
  Int3 first, last;
};

// A patch inside one brick: rows of 4 sites along x, `edge` rows along y and z. `start` is moved down from
// `first` where the patch would pass the brick's end; the sites gained weigh 0.
struct PatchCorner {
  size_t slot;
  int offset; // of the first row in the brick
  Int3 start; // site
};

// False when the patch leaves the brick or the coset: then place_patch knows.
[[nodiscard]] inline bool patch_in_one_brick(const Int3& dims, const Int3& brick_dims, int edge,
                                             const PatchSpan& s, PatchCorner& corner) {
  int crossing = 0; // a sign bit: an index below 0, at or beyond the end, or the brick's end between the two
  for (size_t a = 0; a < 3; ++a)
    crossing |=
        s.first[a] | (dims[a] - 1 - s.last[a]) | -static_cast<int>((s.first[a] ^ s.last[a]) >= brick_edge);
  if (crossing < 0) return false;
  constexpr int in_brick = brick_edge - 1;
  const Int3 room{brick_edge - patch_edge, brick_edge - edge, brick_edge - edge};
  Int3 at;
  for (size_t a = 0; a < 3; ++a) {
    const int i = s.first[a] & in_brick;
    at[a] = i < room[a] ? i : room[a];
    corner.start[a] = s.first[a] - i + at[a];
  }
  corner.slot = (static_cast<size_t>(s.first[2] / brick_edge) * static_cast<size_t>(brick_dims[1]) +
                 static_cast<size_t>(s.first[1] / brick_edge)) *
                    static_cast<size_t>(brick_dims[0]) +
                static_cast<size_t>(s.first[0] / brick_edge);
  corner.offset = (at[2] * brick_edge + at[1]) * brick_edge + at[0];
  return true;
}

// A patch where bricks or mirrors meet. Per axis its sites lie next to each other, so in at most two bricks:
// those along x are cut into pieces of 4 lanes that lie in one brick each; rows lie in quarters of the (y, z)
// plane.
struct PatchPlace {
  struct Axis {
    int bricks = 1; // 1 or 2
    int low = 0;    // the lower brick along the axis; the upper one follows
    // Of each site: which of the two, and its place in it, 0 to 15.
    alignas(16) std::array<int32_t, patch_edge> half{}, site{};
  };
  Axis x, y, z;
  bool folded = false;                   // mirror images along x
  std::array<int, 2> lane0{};            // per piece: the site of the brick in lane 0; the first of four
  std::array<size_t, 2> slot{};          // of the brick that holds a piece in quarter 0
  std::array<size_t, 4> quarter_slots{}; // slots from there to quarter 2 * (z half) + (y half)

  // Row (y, z) of the patch: its quarter, and where its site 0 along x lies in the brick.
  [[nodiscard]] size_t quarter(size_t row_y, size_t row_z) const {
    return static_cast<size_t>(y.half[row_y] + 2 * z.half[row_z]);
  }
  [[nodiscard]] int row(size_t row_y, size_t row_z) const {
    return (z.site[row_z] * brick_edge + y.site[row_y]) * brick_edge;
  }
};

// Places the mirror images among 4 sites of an axis from `first`, of which `count` take part.
void place_mirrored(const BrickLayer& layer, size_t axis, int first, int count, PatchPlace::Axis& out);

// Returns whether there are mirror images.
inline bool place_axis(const BrickLayer& layer, size_t axis, int first, int count, PatchPlace::Axis& out) {
  const int last = first + count - 1;
  if (first < 0 || last >= layer.dims()[axis]) {
    place_mirrored(layer, axis, first, count, out);
    return true;
  }
  out.low = first / brick_edge;
  out.bricks = 1 + (last / brick_edge != out.low);
  const int border = out.bricks == 2 ? (out.low + 1) * brick_edge : INT32_MAX;
  for (int i = 0; i < patch_edge; ++i) {
    const int at = first + i < last ? first + i : last; // those that take no part stay in these bricks
    out.half[static_cast<size_t>(i)] = at >= border;
    out.site[static_cast<size_t>(i)] = at % brick_edge;
  }
  return false;
}

inline PatchPlace place_patch(const BrickLayer& layer, int edge, const PatchSpan& span) {
  PatchPlace p;
  const int count = span.last[0] - span.first[0] + 1;
  p.folded = place_axis(layer, 0, span.first[0], count < 1 ? 1 : count, p.x);
  place_axis(layer, 1, span.first[1], edge, p.y);
  place_axis(layer, 2, span.first[2], edge, p.z);
  // Sites of a brick before the last are its last ones.
  constexpr int room = brick_edge - patch_edge;
  p.lane0[0] = p.x.bricks == 2 || p.x.site[0] > room ? room : p.x.site[0];
  const Int3& n = layer.brick_dims();
  p.slot[0] = layer.slot(p.x.low, p.y.low, p.z.low);
  p.slot[1] = p.slot[0] + 1;
  const size_t up_y = p.y.bricks == 2 ? static_cast<size_t>(n[0]) : 0;
  const size_t up_z = p.z.bricks == 2 ? static_cast<size_t>(n[0]) * static_cast<size_t>(n[1]) : 0;
  p.quarter_slots = {0, up_y, up_z, up_y + up_z};
  return p;
}

} // namespace bccsplat
