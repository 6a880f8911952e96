#include "slice/dense_sites.h"

#include <algorithm>
#include <cstring>

namespace bccsplat {
namespace {

// Per axis: where each site of a box lives.
struct Sites {
  std::array<int, SiteBox::max_rows> brick, place;
};

Sites fold_axis(const BrickLayer& layer, size_t axis, int origin, int size) {
  Sites s;
  for (int i = 0; i < size; ++i) {
    int at = origin + i;
    if (at < 0 || at >= layer.dims()[axis]) at = layer.lattice().mirror(axis, layer.coset(), at);
    s.brick[static_cast<size_t>(i)] = at / brick_edge, s.place[static_cast<size_t>(i)] = at % brick_edge;
  }
  return s;
}

// Sites along x that lie in one brick and rise by one.
struct Run {
  int start, length, brick, place;
};

struct Runs {
  std::array<Run, SiteBox::max_length> run; // mirror images stand alone
  size_t count = 0;
};

void fold_runs(const BrickLayer& layer, int origin, int size, Runs& runs) {
  for (int i = 0; i < size;) {
    int at = origin + i, length = 1;
    if (at >= 0 && at < layer.dims()[0])
      length = std::min({size - i, brick_edge - at % brick_edge, layer.dims()[0] - at});
    else
      at = layer.lattice().mirror(0, layer.coset(), at);
    runs.run[runs.count++] = {i, length, at / brick_edge, at % brick_edge};
    i += length;
  }
}

} // namespace

bool gather_box(const BrickLayer& layer, const SiteBox& box, float* out) {
  const Sites y = fold_axis(layer, 1, box.origin[1], box.size[1]);
  const Sites z = fold_axis(layer, 2, box.origin[2], box.size[2]);
  Runs x;
  fold_runs(layer, box.origin[0], box.size[0], x);
  bool any = false;
  for (size_t k = 0; k < static_cast<size_t>(box.size[2]); ++k)
    for (size_t j = 0; j < static_cast<size_t>(box.size[1]); ++j, out += box.size[0]) {
      const int row = (z.place[k] * brick_edge + y.place[j]) * brick_edge;
      for (size_t r = 0; r < x.count; ++r) {
        const Run& run = x.run[r];
        const Brick* brick = layer.brick(run.brick, y.brick[j], z.brick[k]);
        any = any || brick;
        const float* from = brick ? brick->value.data() + row + run.place : air_brick();
        std::copy_n(from, run.length, out + run.start);
      }
    }
  return any;
}

bool DenseScratch::reserve(const FootprintPlan& plan, const std::array<SiteBox, 2>& box, size_t points,
                           bool merged, bool slopes) {
  constexpr size_t vector = 16; // floats: what is written by whole vectors must not reach into the next layer
  size_t used = 0, rows = 0, copied = 0, largest = 0;
  for (size_t c = 0; c < static_cast<size_t>(plan.cosets); ++c) {
    const Int3& n = box[c].size;
    if (n[0] > SiteBox::max_length || n[1] > SiteBox::max_rows || n[2] > SiteBox::max_rows) return false;
    DenseSites& s = sites[c];
    s.box = box[c];
    s.row = static_cast<size_t>(n[0]);
    s.plane = s.row * static_cast<size_t>(n[1]);
    s.layer = (s.plane * static_cast<size_t>(n[2]) + vector - 1) / vector * vector;
    s.merged = merged;
    s.layers = 0;
    const size_t layers = merged ? static_cast<size_t>(plan.depth) : plan.coset[c].layer.size();
    rows += layers * static_cast<size_t>(n[1]) * static_cast<size_t>(n[2]);
    copied += layers * s.layer;
    const size_t kept = merged ? (slopes ? 2 : 1) : layers;
    if (used + kept * s.layer > capacity) return false;
    s.value = floats.data() + used;
    used += kept * s.layer;
    largest = std::max(largest, s.layer);
  }
  if (used + largest > capacity) return false;
  single = floats.data() + used;
  // Measured: a row costs about as much as a fifth of what a copied point saves, a vector of floats a tenth
  // of it.
  return rows + copied / 32 <= 4 * points;
}

} // namespace bccsplat
