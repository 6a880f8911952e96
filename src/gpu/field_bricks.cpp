// SPDX-License-Identifier: Apache-2.0
// Bricks are filled row by row; which of them are not all zeros is known before any is stored.
#include "gpu/field_bricks.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>

#include "gpu/shader.h"

namespace bccsplat {
namespace {

// Sites beyond the ends that samples outside the domain depend on.
constexpr int sites_beyond = 4;
constexpr int cell_edge = 2;

// The sites of a coset that stand where those of bricks do, along each axis, borders included.
struct SiteMap {
  std::array<std::vector<int32_t>, 3> site;
  SiteMap(const Lattice3& lattice, int coset, const FieldBricks& bricks) {
    for (size_t a = 0; a < 3; ++a)
      for (int i = -bricks.border; i < brick_edge * bricks.bricks[a] + bricks.border; ++i)
        site[a].push_back(lattice.mirror(a, coset, bricks.first_site[a] + i));
  }
};

// Fills bricks from a layer of one coset.
class Filler {
 public:
  Filler(const BrickLayer& layer, const FieldBricks& bricks)
      : layer_(layer), edge_(bricks.edge), map_(layer.lattice(), layer.coset(), bricks) {}

  // Fills a brick with its border; returns whether any of it is not zero.
  bool fill(const Int3& brick, float* out) const {
    bool any = false;
    for (int z = 0; z < edge_; ++z)
      for (int y = 0; y < edge_; ++y, out += edge_)
        any |= fill_row(map_.site[0].data() + brick_edge * brick[0],
                        map_.site[1][static_cast<size_t>(brick_edge) * brick[1] + y],
                        map_.site[2][static_cast<size_t>(brick_edge) * brick[2] + z], out);
    return any;
  }

 private:
  bool fill_row(const int32_t* x, int32_t y, int32_t z, float* out) const {
    const size_t row = static_cast<size_t>(z % brick_edge * brick_edge + y % brick_edge) * brick_edge;
    const Brick* from = nullptr;
    int at = -1;
    bool any = false;
    for (int i = 0; i < edge_; ++i) {
      const int bx = x[i] / brick_edge;
      if (bx != at) at = bx, from = layer_.brick(bx, y / brick_edge, z / brick_edge);
      out[i] = from ? from->value[row + static_cast<size_t>(x[i] % brick_edge)] : 0.0f;
      any |= out[i] != 0;
    }
    return any;
  }

  const BrickLayer& layer_;
  int edge_;
  SiteMap map_;
};

void include(std::array<float, 2>& range, float value) {
  range[0] = std::min(range[0], value), range[1] = std::max(range[1], value);
}

// Adds the own sites of a brick to the ranges of the cells that hold them.
void add_ranges(const FieldBricks& bricks, const Int3& brick, const float* value,
                std::vector<std::array<float, 2>>& range) {
  constexpr int per_brick = brick_edge / cell_edge;
  for (int z = 0; z < brick_edge; ++z)
    for (int y = 0; y < brick_edge; ++y) {
      const float* const row =
          value + ((z + bricks.border) * bricks.edge + y + bricks.border) * bricks.edge + bricks.border;
      const size_t first = (static_cast<size_t>(brick[2] * per_brick + z / cell_edge) * bricks.cells[1] +
                            brick[1] * per_brick + y / cell_edge) *
                               bricks.cells[0] +
                           static_cast<size_t>(brick[0]) * per_brick;
      for (int x = 0; x < brick_edge; ++x) include(range[first + static_cast<size_t>(x / cell_edge)], row[x]);
    }
}

// Calls body(first, stride) for each line of cells along an axis.
void each_line(const Int3& cells, size_t axis, const std::function<void(size_t first, size_t stride)>& body) {
  const std::array<size_t, 3> stride{1, static_cast<size_t>(cells[0]),
                                     static_cast<size_t>(cells[0]) * cells[1]};
  const size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
  for (int j = 0; j < cells[v]; ++j)
    for (int i = 0; i < cells[u]; ++i) body(i * stride[u] + j * stride[v], stride[axis]);
}

// Widens every range by those of the cells up to `around` away.
void widen_ranges(FieldBricks& bricks, int around) {
  std::vector<std::array<float, 2>> line;
  for (size_t axis = 0; axis < 3; ++axis)
    each_line(bricks.cells, axis, [&](size_t first, size_t stride) {
      const int count = bricks.cells[axis];
      line.clear();
      for (int i = 0; i < count; ++i) line.push_back(bricks.range[first + i * stride]);
      for (int i = 0; i < count; ++i)
        for (int j = std::max(i - around, 0); j <= std::min(i + around, count - 1); ++j) {
          auto& range = bricks.range[first + i * stride];
          include(range, line[j][0]), include(range, line[j][1]);
        }
    });
}

// Makes ranges of coefficients those of the field without corrections.
void bound_field(FieldBricks& bricks, bool bcc) {
  const auto most = static_cast<float>(largest_site_sum(bcc));
  for (auto& [low, high] : bricks.range) low *= most, high *= most;
}

// The cells that hold the points of a box, lattice units.
std::array<Int3, 2> cells_of(const FieldBricks& bricks, bool bcc, const Vec3& middle, const Vec3& half) {
  std::array<Int3, 2> out{};
  for (size_t a = 0; a < 3; ++a)
    for (size_t side = 0; side < 2; ++side) {
      const double at = (middle[a] + (side == 0 ? -half[a] : half[a])) / coset_pitch(bcc);
      const auto site =
          static_cast<int32_t>(std::clamp(std::floor(at + 0.5), -1e9, 1e9)) - bricks.first_site[a];
      out[side][a] = std::clamp(site / cell_edge, 0, bricks.cells[a] - 1);
    }
  return out;
}

// Adds what corrections add to the field: nowhere more than the largest of those at a cell's corners.
void add_fixes(const Slice& slice, FieldBricks& bricks) {
  if (bricks.fixes.empty()) return;
  const Affine3 to_lattice = slice.lattice_to_slice.inverse();
  Vec3 half{}; // of the box around a correction
  for (size_t a = 0; a < 3; ++a)
    for (size_t k = 0; k < 3; ++k) half[a] += std::fabs(to_lattice.linear[a][k]);
  std::vector<std::array<float, 2>> fixes(bricks.range.size());
  slice.corrections->add.each([&](const Int3& at, float value) {
    const Vec3 uvw = slice.corrections->origin + Vec3{1.0 * at[0], 1.0 * at[1], 1.0 * at[2]};
    const auto [first, last] = cells_of(bricks, slice.lattice.bcc, to_lattice.point(uvw), half);
    for (int z = first[2]; z <= last[2]; ++z)
      for (int y = first[1]; y <= last[1]; ++y)
        for (int x = first[0]; x <= last[0]; ++x)
          include(fixes[(static_cast<size_t>(z) * bricks.cells[1] + y) * bricks.cells[0] + x], value);
  });
  for (size_t n = 0; n < fixes.size(); ++n)
    bricks.range[n][0] += fixes[n][0], bricks.range[n][1] += fixes[n][1];
}

// Marks the holes of a coset where its sites stand in bricks, mirrored ones included.
void mark_holes(const Slice& slice, int coset, FieldBricks& bricks) {
  const SiteMap map(slice.lattice, coset, bricks);
  const BrickLayer& layer = slice.coset[static_cast<size_t>(coset)];
  const Int3 size = {bricks.holes.size[0], bricks.holes.size[1],
                     bricks.holes.size[2] / slice.lattice.cosets()};
  const auto site = [&](size_t a, int i) { return map.site[a][static_cast<size_t>(i + bricks.border)]; };
  for (int z = 0; z < size[2]; ++z)
    for (int y = 0; y < size[1]; ++y)
      for (int x = 0; x < size[0]; ++x) {
        const Int3 at{site(0, x), site(1, y), site(2, z)};
        const Brick* const brick = layer.brick(at[0] / brick_edge, at[1] / brick_edge, at[2] / brick_edge);
        if (brick && brick->is_hole((at[2] % brick_edge * brick_edge + at[1] % brick_edge) * brick_edge +
                                    at[0] % brick_edge))
          bricks.holes.set(x, y, z + coset * size[2]);
      }
}

void find_holes(const Slice& slice, FieldBricks& bricks) {
  if (!slice.has_holes || slice.holes_by_mask) return;
  const int cosets = slice.lattice.cosets();
  bricks.holes = BitBox(
      {brick_edge * bricks.bricks[0], brick_edge * bricks.bricks[1], cosets * brick_edge * bricks.bricks[2]});
  for (int c = 0; c < cosets; ++c) mark_holes(slice, c, bricks);
}

// Ranges of coefficients become those of the field.
void finish_ranges(const Slice& slice, FieldBricks& b) {
  widen_ranges(b, b.border);
  bound_field(b, slice.lattice.bcc);
  add_fixes(slice, b);
}

Int3 position_of(size_t n, const Int3& bricks) {
  const size_t nx = bricks[0], ny = bricks[1];
  return {static_cast<int32_t>(n % nx), static_cast<int32_t>(n / nx % ny),
          static_cast<int32_t>(n / (nx * ny) % static_cast<size_t>(bricks[2]))};
}

size_t brick_count(const FieldBricks& b) {
  return static_cast<size_t>(b.bricks[0]) * b.bricks[1] * b.bricks[2];
}

FieldBricks lay_out(const Slice& slice, int border) {
  FieldBricks b;
  b.border = border, b.edge = brick_edge + 2 * border;
  for (size_t a = 0; a < 3; ++a) {
    b.first_site[a] = -sites_beyond;
    b.bricks[a] = (slice.lattice.dims(0)[a] + 2 * sites_beyond + brick_edge - 1) / brick_edge;
    b.cells[a] = b.bricks[a] * brick_edge / cell_edge;
  }
  b.brick_at.resize(static_cast<size_t>(slice.lattice.cosets()) * b.bricks[0] * b.bricks[1] * b.bricks[2]);
  b.range.resize(static_cast<size_t>(b.cells[0]) * b.cells[1] * b.cells[2]);
  return b;
}

} // namespace

LayerBricks make_layer_bricks(const BrickLayer& layer, const FieldBricks& like, const Context& context) {
  LayerBricks b;
  b.brick_at.resize(brick_count(like)), b.range.resize(like.range.size());
  const Filler filler(layer, like);
  const size_t size = static_cast<size_t>(like.edge) * like.edge * like.edge;
  context.tasks.parallel_for(b.brick_at.size(), [&](uint64_t n) {
    context.progress.check();
    std::vector<float> values(size);
    const Int3 at = position_of(n, like.bricks);
    if (!filler.fill(at, values.data())) return;
    b.brick_at[n] = 1;
    add_ranges(like, at, values.data(), b.range);
  });
  uint32_t count = 1; // brick 0 is zeros
  for (uint32_t& brick : b.brick_at)
    if (brick != 0) brick = count++;
  b.memory = Reservation(context.memory, sizeof(float) * count * size, "the bricks of a layer for the GPU");
  b.value.resize(count * size);
  context.tasks.parallel_for(b.brick_at.size(), [&](uint64_t n) {
    context.progress.check();
    if (b.brick_at[n] != 0)
      (void)filler.fill(position_of(n, like.bricks), b.value.data() + b.brick_at[n] * size);
  });
  return b;
}

namespace {

// Appends the bricks of a coset, of which the first is there already.
void append_coset(const LayerBricks& from, size_t coset, FieldBricks& b) {
  const size_t size = static_cast<size_t>(b.edge) * b.edge * b.edge, first = b.count() - 1;
  b.value.insert(b.value.end(), from.value.begin() + static_cast<std::ptrdiff_t>(size), from.value.end());
  for (size_t n = 0; n < from.brick_at.size(); ++n)
    if (from.brick_at[n] != 0)
      b.brick_at[coset * from.brick_at.size() + n] = static_cast<uint32_t>(first + from.brick_at[n]);
  for (size_t n = 0; n < b.range.size(); ++n)
    include(b.range[n], from.range[n][0]), include(b.range[n], from.range[n][1]);
}

} // namespace

FieldBricks make_field_bricks(const Slice& slice, int border, const Context& context) {
  FieldBricks b = lay_out(slice, border);
  b.fixes = make_field_fixes(slice), b.missing = make_missing_samples(slice, context), find_holes(slice, b);
  b.value.resize(static_cast<size_t>(b.edge) * b.edge * b.edge); // brick 0 is zeros
  for (size_t coset = 0; coset < static_cast<size_t>(slice.lattice.cosets()); ++coset) {
    const LayerBricks layer = make_layer_bricks(slice.coset[coset], b, context);
    b.memory = {};
    b.memory = Reservation(context.memory, b.bytes() + sizeof(float) * layer.value.size(),
                           "the bricks of a slice for the GPU");
    append_coset(layer, coset, b);
  }
  finish_ranges(slice, b);
  return b;
}

FieldBricks no_bricks(const Slice& slice, int border) { return lay_out(slice, border); }

FieldBricks moment_bricks(const Slice& slice, int border, std::span<const MomentLayer> layers, float most) {
  FieldBricks b = lay_out(slice, border);
  const size_t per_coset = brick_count(b);
  for (const auto& [coset, layer] : layers) {
    for (size_t n = 0; n < per_coset; ++n)
      b.brick_at[coset * per_coset + n] |= layer->brick_at[n] != 0 ? 1u : 0u;
    for (size_t n = 0; n < b.range.size(); ++n)
      include(b.range[n], most * layer->range[n][0]), include(b.range[n], most * layer->range[n][1]);
  }
  uint32_t count = 1;
  for (uint32_t& brick : b.brick_at)
    if (brick != 0) brick = count++;
  b.fixes = make_field_fixes(slice);
  finish_ranges(slice, b);
  return b;
}

std::vector<uint8_t> cells_around(const Int3& cells, int around, std::vector<uint8_t> marked) {
  constexpr int most = 255;
  // Chebyshev's distance to the nearest mark, axis by axis: the least over a line of the larger of the
  // distance along it and that of the cell there.
  std::vector<int> distance(marked.size()), line;
  for (size_t n = 0; n < marked.size(); ++n) distance[n] = marked[n] ? 0 : most + around;
  for (size_t axis = 0; axis < 3; ++axis)
    each_line(cells, axis, [&](size_t first, size_t stride) {
      const int count = cells[axis];
      line.clear();
      for (int i = 0; i < count; ++i) line.push_back(distance[first + i * stride]);
      for (int i = 0; i < count; ++i) {
        int& best = distance[first + i * stride];
        for (int away = 1; away < best; ++away) {
          if (i - away >= 0) best = std::min(best, std::max(away, line[i - away]));
          if (i + away < count) best = std::min(best, std::max(away, line[i + away]));
          if (i - away < 0 && i + away >= count) break;
        }
      }
    });
  for (size_t n = 0; n < marked.size(); ++n)
    marked[n] = static_cast<uint8_t>(std::clamp(distance[n] - around, 0, most));
  return marked;
}

} // namespace bccsplat
