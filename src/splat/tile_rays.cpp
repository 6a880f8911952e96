#include "splat/tile_rays.h"

#include <algorithm>
#include <array>
#include <limits>

namespace bccsplat {

TileRays make_rays(const Slice& slice, const SheetView& view, const PlannedTile& tile, int pitch,
                   float* planes, PixelPlanes& out) {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  const auto count = static_cast<size_t>(pitch) * static_cast<size_t>(tile.height);
  float *const enter = planes, *const leave = planes + count, *const path = planes + 2 * count;
  float *const vx = planes + 3 * count, *const vy = planes + 4 * count, *const vz = planes + 5 * count;
  out.enter = enter, out.leave = leave, out.path = path;
  out.view_x = vx, out.view_y = vy, out.view_z = vz;
  TileRays rays;
  // Of an orthographic view, all rays are alike.
  const auto set_direction = [&](double i, double j, size_t p) {
    const Vec3 ray = view.lattice_to_world.vector(view.ray(i, j));
    const double step = length(ray);
    path[p] = static_cast<float>(step);
    vx[p] = static_cast<float>(-ray[0] / step), vy[p] = static_cast<float>(-ray[1] / step);
    vz[p] = static_cast<float>(-ray[2] / step);
  };
  if (!view.perspective) set_direction(0, 0, 0);
  const std::array<float, 4> common{path[0], vx[0], vy[0], vz[0]};
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (int y = 0; y < tile.height; ++y)
    for (int x = 0; x < pitch; ++x) {
      const auto p = static_cast<size_t>(y) * static_cast<size_t>(pitch) + static_cast<size_t>(x);
      enter[p] = infinity, leave[p] = -infinity;
      path[p] = vx[p] = vy[p] = vz[p] = 0;
      if (x >= tile.width) continue;
      const double i = tile.x + x, j = tile.y + y;
      const auto [k0, k1] = ray_interval(slice, view, i, j);
      if (view.perspective)
        set_direction(i, j, p);
      else
        path[p] = common[0], vx[p] = common[1], vy[p] = common[2], vz[p] = common[3];
      if (!(k0 < k1)) continue;
      enter[p] = static_cast<float>(k0), leave[p] = static_cast<float>(k1);
      low = std::min(low, k0), high = std::max(high, k1);
      ++rays.open;
    }
  if (rays.open > 0) rays.low = low, rays.high = high;
  return rays;
}

void find_holes(const Slice& slice, const SheetView& view, const PlannedTile& tile, int64_t k,
                const PixelPlanes& rays, int pitch, uint8_t* hole) {
  const auto sheet = static_cast<float>(k);
  for (int y = 0; y < tile.height; ++y)
    for (int x = 0; x < tile.width; ++x) {
      const auto p = static_cast<size_t>(y) * static_cast<size_t>(pitch) + static_cast<size_t>(x);
      const bool inside = sheet + 0.5f > rays.enter[p] && sheet - 0.5f < rays.leave[p];
      hole[p] = inside && slice.is_hole(view.sample(tile.x + x, tile.y + y, static_cast<double>(k)));
    }
}

} // namespace bccsplat
