// SPDX-License-Identifier: Apache-2.0
// Copies the sites of a patch that lies in several bricks or crosses an end of the lattice.
#include "field/footprint/patch_sites.h"

#include <algorithm>
#include <cstring>

namespace bccsplat {
namespace {

constexpr size_t copy_row = 2 * patch_edge, copy_plane = copy_row * patch_edge;

// The sites of an axis of a patch. They lie next to each other, mirrored or not, so in at most two bricks.
struct PatchAxis {
  int low = 0;    // the lower brick
  int bricks = 1; // 1 or 2
  bool mirrored = false;
  std::array<uint32_t, patch_edge> half{}; // of each site: 1 in the upper brick
  std::array<uint32_t, patch_edge> site{}; // and its place in the brick
};

void mirror_axis(const BrickLayer& layer, size_t axis, int first, int count, PatchAxis& p) {
  std::array<int, patch_edge> at;
  for (int i = 0; i < patch_edge; ++i) // those that take no part repeat the last one
    at[i] = layer.lattice().mirror(axis, layer.coset(), first + std::min(i, count - 1));
  const auto [low, high] = std::minmax_element(at.begin(), at.end());
  p.low = *low / brick_edge;
  p.bricks = 1 + (*high / brick_edge != p.low);
  p.mirrored = true;
  for (size_t i = 0; i < patch_edge; ++i) {
    p.half[i] = at[i] / brick_edge != p.low;
    p.site[i] = at[i] % brick_edge;
  }
}

// `read` sites from `first` on, of which `count` take part.
PatchAxis place_axis(const BrickLayer& layer, size_t axis, int first, int count, int read) {
  PatchAxis p;
  if (first < 0 || first + count > layer.dims()[axis]) {
    mirror_axis(layer, axis, first, count, p);
    return p;
  }
  const uint32_t at = first;
  p.low = first / brick_edge;
  p.bricks = at % brick_edge + count > brick_edge ? 2 : 1;
  for (uint32_t i = 0; i < static_cast<uint32_t>(read); ++i) {
    const uint32_t site = at % brick_edge + i;
    p.half[i] = site / brick_edge, p.site[i] = site % brick_edge;
  }
  return p;
}

// The layout that all layers of a patch have in common.
struct Rows {
  std::array<uint32_t, patch_rows> quarter; // of the bricks that a row lies in: 2 * half of z + half of y
  std::array<uint32_t, patch_rows> begin;   // of the row in its brick
  std::array<uint32_t, patch_rows> to;      // in the copy
  size_t count = 0;

  Rows(const PatchAxis& y, const PatchAxis& z, size_t edge) {
    for (size_t k_z = 0; k_z < edge; ++k_z)
      for (size_t k_y = 0; k_y < edge; ++k_y, ++count) {
        quarter[count] = 2 * z.half[k_z] + y.half[k_y];
        begin[count] = (z.site[k_z] * brick_edge + y.site[k_y]) * brick_edge;
        to[count] = static_cast<uint32_t>(k_z * copy_plane + k_y * copy_row);
      }
  }
};
using Quarters = std::array<const float*, 4>;

// Rows in one brick, from site `first` on.
void copy_whole(const Rows& rows, const Quarters& brick, size_t first, float* copy) {
  for (size_t r = 0; r < rows.count; ++r)
    std::memcpy(copy + rows.to[r], brick[rows.quarter[r]] + rows.begin[r] + first,
                patch_edge * sizeof(float));
}

// Rows in two bricks: the end of one, and the beginning of the next behind it.
void copy_pair(const Rows& rows, const Quarters& low, const Quarters& high, float* copy) {
  for (size_t r = 0; r < rows.count; ++r) {
    const size_t q = rows.quarter[r], from = rows.begin[r];
    std::memcpy(copy + rows.to[r], low[q] + from + brick_edge - patch_edge, patch_edge * sizeof(float));
    std::memcpy(copy + rows.to[r] + patch_edge, high[q] + from, patch_edge * sizeof(float));
  }
}

void copy_mirrored(const Rows& rows, const PatchAxis& x, const std::array<Quarters, 2>& brick, float* copy) {
  for (size_t r = 0; r < rows.count; ++r)
    for (size_t i = 0; i < patch_edge; ++i)
      copy[rows.to[r] + i] = brick[x.half[i]][rows.quarter[r]][rows.begin[r] + x.site[i]];
}

// Returns whether a patch crosses the end of a periodic axis: its sites may lie in three bricks, far apart.
bool crosses_turn(const BrickLayer& any, const std::array<int32_t, 4>& first, int edge) {
  for (size_t a = 0; a < 3; ++a)
    if (any.lattice().periodic[a] && (first[a] < 0 || first[a] + edge > any.dims()[a])) return true;
  return false;
}

// Such a patch, site by site.
void copy_turned(const FootprintPlan& plan, const FootprintPlan::Coset& coset, PatchSites& patch) {
  const BrickLayer& any = *coset.layer[0];
  std::array<std::array<int, patch_edge>, 3> at{};
  for (size_t a = 0; a < 3; ++a)
    for (int i = 0; i < patch_edge; ++i) // those that take no part repeat the last one
      at[a][i] = any.lattice().mirror(a, any.coset(), patch.first[a] + std::min(i, plan.edge - 1));
  patch.row = copy_row, patch.plane = copy_plane;
  const size_t edge = plan.edge;
  for (size_t k = 0; k < static_cast<size_t>(plan.depth); ++k) {
    const auto layer = patch.first[3] + k; // wraps round below 0
    if (layer >= coset.bricks.size()) continue;
    const size_t to = patch.layers;
    bool kept = false;
    for (size_t z = 0; z < edge; ++z)
      for (size_t y = 0; y < edge; ++y)
        for (size_t x = 0; x < patch_edge; ++x) {
          const Int3 site{at[0][x], at[1][y], at[2][z]};
          const Brick* brick =
              coset.bricks[layer][any.slot(site[0] / brick_edge, site[1] / brick_edge, site[2] / brick_edge)]
                  .get();
          kept = kept || brick;
          const int place =
              (site[2] % brick_edge * brick_edge + site[1] % brick_edge) * brick_edge + site[0] % brick_edge;
          patch.copy[to][z * copy_plane + y * copy_row + x] = brick ? brick->value[place] : 0.0f;
        }
    if (!kept) continue;
    ++patch.layers;
    patch.place[to] = k, patch.corner[to] = patch.copy[to].data();
  }
}

} // namespace

void copy_patch(const FootprintPlan& plan, const FootprintPlan::Coset& coset, PatchSites& patch) {
  const BrickLayer& any = *coset.layer[0];
  const auto& first = patch.first;
  if (crosses_turn(any, first, plan.edge)) return copy_turned(plan, coset, patch);
  const PatchAxis x = place_axis(any, 0, first[0], plan.edge, patch_edge),
                  y = place_axis(any, 1, first[1], plan.edge, plan.edge),
                  z = place_axis(any, 2, first[2], plan.edge, plan.edge);
  const Rows rows(y, z, plan.edge);
  constexpr uint32_t room = brick_edge - patch_edge;
  patch.row = copy_row, patch.plane = copy_plane;
  const size_t slot = any.slot(x.low, y.low, z.low), step_y = coset.brick_dims[0],
               step_z = step_y * coset.brick_dims[1];
  // Where there is one brick along an axis it is used for both.
  const size_t up_x = x.bricks == 2 ? 1 : 0, up_y = y.bricks == 2 ? step_y : 0,
               up_z = z.bricks == 2 ? step_z : 0;
  const std::array<size_t, 4> quarter{slot, slot + up_y, slot + up_z, slot + up_z + up_y};
  // Whole rows begin where 4 sites fit into the brick.
  const size_t begin = x.mirrored || up_x ? 0 : std::min(x.site[0], room);
  const size_t skip = x.mirrored ? 0 : x.site[0] - (up_x ? room : begin);
  for (size_t k = 0; k < static_cast<size_t>(plan.depth); ++k) {
    const auto at = first[3] + k; // wraps round below 0
    if (at >= coset.bricks.size()) continue;
    std::array<Quarters, 2> brick; // by half along x
    bool kept = false;
    for (size_t hx = 0; hx <= up_x; ++hx)
      for (size_t q = 0; q < 4; ++q) {
        const Brick* b = coset.bricks[at][quarter[q] + hx].get();
        brick[hx][q] = b ? b->value.data() : air_brick();
        kept = kept || b;
      }
    if (!kept) continue;
    const size_t to = patch.layers++;
    patch.place[to] = k;
    float* copy = patch.copy[to].data();
    patch.corner[to] = copy + skip;
    if (x.mirrored)
      copy_mirrored(rows, x, up_x ? brick : std::array{brick[0], brick[0]}, copy);
    else if (up_x)
      copy_pair(rows, brick[0], brick[1], copy);
    else
      copy_whole(rows, brick[0], begin, copy);
  }
}

} // namespace bccsplat
