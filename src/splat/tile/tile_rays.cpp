// SPDX-License-Identifier: Apache-2.0
// Cuts the rays of a tile's pixels by the half-spaces of the domain, a row at a time, so that loops without
// branches do it; ray_interval() of view.h is the same for one ray, and the reference in tests.
#include "splat/tile/tile_rays.h"

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "base/grid.h"

namespace bccsplat {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

// The linear form constant + per_i i + per_j j of pixel (i, j).
struct PixelForm {
  double constant, per_i, per_j;
};

// The rays of a row of pixels, cut by the half-spaces that make the domain; as ray_interval().
class RowCuts {
 public:
  RowCuts(const Slice& slice, const SheetView& view)
      : perspective_(view.perspective), in_front_(view.perspective || view.in_front), depth_(view.depth) {
    const DrawnBox box = drawn_box(slice);
    for (size_t a = 0; a < 3; ++a) {
      Vec3 normal{};
      normal[a] = 1;
      add(view, normal, -box.begin[a]);
      add(view, -1.0 * normal, box.end[a]);
    }
    for (const auto* const clips : {&slice.clip, &view.clip})
      for (const HalfSpace& h : *clips) add(view, h.normal, h.offset);
  }

  // Sets the sheet numbers first[n] .. last[n] between which the ray of pixel (i[n], j) is inside.
  void row(const std::vector<double>& i, double j, std::vector<double>& first,
           std::vector<double>& last) const {
    std::fill(first.begin(), first.end(), in_front_ ? -depth_ : -infinite);
    std::fill(last.begin(), last.end(), infinite);
    const size_t count = i.size();
    const double* const at = i.data();
    double *const near = first.data(), *const far = last.data();
    for (const PixelForm& f : enters_) {
      const double start = f.constant + f.per_j * j, per_i = f.per_i;
      for (size_t n = 0; n < count; ++n) near[n] = std::max(near[n], start + per_i * at[n]);
    }
    for (const PixelForm& f : leaves_) {
      const double start = f.constant + f.per_j * j, per_i = f.per_i;
      for (size_t n = 0; n < count; ++n) far[n] = std::min(far[n], start + per_i * at[n]);
    }
    for (const PixelForm& f : along_) {
      const double start = f.constant + f.per_j * j, per_i = f.per_i;
      for (size_t n = 0; n < count; ++n) far[n] = start + per_i * at[n] < 0 ? -infinite : far[n];
    }
    for (const Fan& f : fans_) {
      const double start = f.slope.constant + f.slope.per_j * j, per_i = f.slope.per_i, offset = f.offset,
                   depth = depth_, outside = offset < 0 ? -infinite : infinite;
      for (size_t n = 0; n < count; ++n) {
        const double slope = start + per_i * at[n], k = -offset / slope - depth;
        near[n] = std::max(near[n], slope > 0 ? k : -infinite);
        far[n] = std::min(far[n], slope < 0 ? k : slope > 0 ? infinite : outside);
      }
    }
  }

 private:
  struct Fan {
    double offset;   // at the eye
    PixelForm slope; // per sheet step of depth
  };

  void add(const SheetView& v, const Vec3& normal, double offset) {
    const double eye = dot(normal, v.eye) + offset, z = dot(normal, v.ez), x = dot(normal, v.ex),
                 y = dot(normal, v.ey);
    if (perspective_)
      fans_.push_back({eye, {z, x, y}});
    else if (z == 0)
      along_.push_back({eye, x, y});
    else
      (z > 0 ? enters_ : leaves_).push_back({-eye / z, -x / z, -y / z});
  }

  bool perspective_, in_front_;
  double depth_;
  std::vector<PixelForm> enters_, leaves_, along_; // orthographic: sheet numbers; values that must not be < 0
  std::vector<Fan> fans_;
};

} // namespace

TileRays make_rays(const Slice& slice, const SheetView& view, const PlannedTile& tile, int pitch,
                   float* planes, PixelPlanes& out) {
  constexpr float never = std::numeric_limits<float>::infinity();
  const auto count = plane_size(pitch, tile.height);
  float *const enter = planes, *const leave = planes + count, *const path = planes + 2 * count;
  float *const vx = planes + 3 * count, *const vy = planes + 4 * count, *const vz = planes + 5 * count;
  out.enter = enter, out.leave = leave, out.path = path;
  out.view_x = vx, out.view_y = vy, out.view_z = vz;
  TileRays rays;
  const size_t width = tile.width, row = pitch;
  // These are world vectors of one sheet step: along the ray of pixel (0, 0), and what a pixel adds in
  // perspective.
  const Affine3& world = view.lattice_to_world;
  const Vec3 ray = world.vector(view.ez), ray_i = world.vector(view.ex), ray_j = world.vector(view.ey);
  const auto set_direction = [&](const Vec3& r, size_t p) {
    const double step = length(r);
    path[p] = static_cast<float>(step);
    vx[p] = static_cast<float>(-r[0] / step), vy[p] = static_cast<float>(-r[1] / step);
    vz[p] = static_cast<float>(-r[2] / step);
  };
  if (!view.perspective) {
    // All rays are alike.
    set_direction(ray, 0);
    for (float* const plane : {path, vx, vy, vz}) std::fill_n(plane, count, plane[0]);
  }
  const RowCuts cuts(slice, view);
  std::vector<double> column(width), first(width), last(width);
  for (size_t x = 0; x < width; ++x) column[x] = tile.x + static_cast<double>(x);
  double low = infinite, high = -infinite;
  for (int y = 0; y < tile.height; ++y) {
    const size_t p = y * row;
    const double j = tile.y + y;
    cuts.row(column, j, first, last);
    if (view.ends.distance)
      for (size_t x = 0; x < width; ++x)
        last[x] = std::min(last[x], view.sheet_at(view.ends.at(tile.x + static_cast<int>(x), tile.y + y)));
    for (size_t x = 0; x < width; ++x) {
      const bool meets = first[x] < last[x];
      enter[p + x] = meets ? static_cast<float>(first[x]) : never;
      leave[p + x] = meets ? static_cast<float>(last[x]) : -never;
      low = std::min(low, meets ? first[x] : infinite), high = std::max(high, meets ? last[x] : -infinite);
      rays.open += meets ? 1 : 0;
    }
    if (view.perspective)
      for (size_t x = 0; x < width; ++x) set_direction(ray + column[x] * ray_i + j * ray_j, p + x);
    std::fill(enter + p + width, enter + p + row, never);
    std::fill(leave + p + width, leave + p + row, -never);
    for (float* const plane : {path, vx, vy, vz}) std::fill(plane + p + width, plane + p + row, 0.0f);
  }
  if (rays.open > 0) rays.low = low, rays.high = high;
  return rays;
}

} // namespace bccsplat
