// SPDX-License-Identifier: Apache-2.0
#include "field/footprint/dense_sites.h"

#include <algorithm>
#include <cstring>

namespace bccsplat {
namespace {

// Sites along an axis that lie in one brick and rise by one; what lies beyond the lattice are runs of one
// site.
struct Run {
  int start, length, brick, place;
};

template<size_t capacity> struct Runs {
  std::array<Run, capacity> run;
  size_t count = 0;

  Runs(const BrickLayer& layer, size_t axis, int origin, int size) {
    for (int i = 0; i < size;) {
      int at = origin + i, length = 1;
      if (at >= 0 && at < layer.dims()[axis])
        length = std::min({size - i, brick_edge - at % brick_edge, layer.dims()[axis] - at});
      else
        at = layer.lattice().mirror(axis, layer.coset(), at);
      run[count++] = {i, length, at / brick_edge, at % brick_edge};
      i += length;
    }
  }
  [[nodiscard]] std::span<const Run> all() const { return std::span(run).first(count); }
};

// The part of a box that lies in one brick; `to` rises by `row` and `plane` floats.
template<class Copy>
void copy_rows(const float* from, int rows, int planes, float* to, size_t row, size_t plane,
               const Copy& copy) {
  for (int z = 0; z < planes; ++z, from += brick_rows, to += plane)
    for (int y = 0; y < rows; ++y) copy(from + y * brick_edge, to + y * row);
}

void copy_part(const float* from, const Run& x, const Run& y, const Run& z, float* to, size_t row,
               size_t plane) {
  const auto copy = [&](const auto& one) { copy_rows(from, y.length, z.length, to, row, plane, one); };
  // Copies at most a brick's row: no call, whole rows without a loop.
  if (x.length == brick_edge)
    copy([](const float* f, float* t) { std::memcpy(t, f, brick_edge * sizeof(float)); });
  else
    copy([n = x.length](const float* f, float* t) {
      int i = 0;
      for (; i + 4 <= n; i += 4) std::memcpy(t + i, f + i, 4 * sizeof(float));
      for (; i < n; ++i) t[i] = f[i];
    });
}

} // namespace

bool gather_box(const BrickLayer& layer, const SiteBox& box, float* out) {
  const Runs<SiteBox::max_length> x(layer, 0, box.origin[0], box.size[0]);
  const Runs<SiteBox::max_length> y(layer, 1, box.origin[1], box.size[1]),
      z(layer, 2, box.origin[2], box.size[2]);
  const auto row = static_cast<size_t>(box.size[0]), plane = row * box.size[1];
  bool any = false;
  for (const Run& in_z : z.all())
    for (const Run& in_y : y.all())
      for (const Run& in_x : x.all()) {
        const Brick* brick = layer.brick(in_x.brick, in_y.brick, in_z.brick);
        any = any || brick;
        const float* from = brick ? brick->value.data() : air_brick();
        copy_part(from + (in_z.place * brick_edge + in_y.place) * brick_edge + in_x.place, in_x, in_y, in_z,
                  out + in_z.start * plane + in_y.start * row + in_x.start, row, plane);
      }
  return any;
}

// What copying may cost, in units of what a copied point saves (measured): a row about a fifth, a vector of
// floats a tenth of it. So copies are made while rows + floats / copied_per_row <= rows_per_point * points.
constexpr size_t copied_per_row = 32, rows_per_point = 4;

bool DenseScratch::reserve(const FootprintPlan& plan, const std::array<SiteBox, 2>& box, size_t points,
                           bool slopes) {
  constexpr size_t vector = 16; // floats: what is read or written by whole vectors must not reach further
  const size_t kept = slopes && !plan.timeless ? 2 : 1;
  size_t used = 0, rows = 0, copied = 0, largest = 0;
  for (size_t c = 0; c < static_cast<size_t>(plan.cosets); ++c) {
    const Int3& n = box[c].size;
    if (n[0] > SiteBox::max_length || n[1] > SiteBox::max_rows || n[2] > SiteBox::max_rows) return false;
    DenseSites& s = sites[c];
    s.box = box[c];
    s.row = n[0];
    s.plane = s.row * n[1];
    s.layer = (s.plane * n[2] + vector - 1) / vector * vector;
    s.air = true;
    const size_t layers = plan.depth;
    rows += layers * n[1] * n[2];
    copied += layers * s.layer;
    if (used + kept * s.layer > capacity) return false;
    s.value = floats.data() + used;
    used += kept * s.layer;
    largest = std::max(largest, s.layer);
  }
  if (used + largest > capacity) return false;
  single = floats.data() + used;
  return rows + copied / copied_per_row <= rows_per_point * points;
}

} // namespace bccsplat
