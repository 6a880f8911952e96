// SPDX-License-Identifier: Apache-2.0
#include "splat/tile/tile_matter.h"

#include <algorithm>
#include <utility>

namespace bccsplat {

TileMatter::TileMatter(const TileJob& job, const PlannedTile& tile, TileMemory& memory,
                       const PixelPlanes& pixel)
    : job_(job), tile_(tile), pixel_(pixel),
      loops_(job.options->reference_loops ? reference_matter_loops() : simd_matter_loops()),
      pitch_(memory.pixel_pitch), pixels_(plane_size(pitch_, tile.height)) {
  memory.matter.reserve(matter_planes(job) * pixels_);
  float* at = memory.matter.data();
  for (auto& sheet : planes_) {
    sheet.resize(job.groups());
    for (MatterPlanes& group : sheet) {
      group = {at, at + pixels_, at + 2 * pixels_, at + 3 * pixels_, nullptr, nullptr};
      if (pixel.value) group.value = at + 4 * pixels_;
      if (pixel.time) group.time = at + 5 * pixels_;
      at += group_planes * pixels_;
    }
  }
}

void TileMatter::clear() {
  for (auto& sheet : used_) sheet.assign(job_.groups(), 0);
}

const MatterPlanes& TileMatter::of(size_t n, size_t group) {
  const MatterPlanes& matter = planes_[n][group];
  if (!std::exchange(used_[n][group], 1)) std::fill_n(matter.red, group_planes * pixels_, 0.0f);
  return matter;
}

void TileMatter::add_front(const TileFront& front, int64_t k, size_t n) {
  const TilePixels& seen = *front.pixels;
  const float end = static_cast<float>(k) + 0.5f;
  for (int y = 0; y < tile_.height; ++y)
    for (int x = 0; x < tile_.width; ++x) {
      const size_t p = plane_index(x, y, pitch_), s = front.pixel(x, y);
      if (!(front.at(x, y) <= end) || end - 1 > pixel_.leave[p]) continue;
      const MatterPlanes& matter = of(n, 0);
      matter.red[p] = opaque_depth * seen.red[s], matter.green[p] = opaque_depth * seen.green[s];
      matter.blue[p] = opaque_depth * seen.blue[s];
      matter.depth[p] = opaque_depth;
      if (matter.value) matter.value[p] = opaque_depth * seen.value[s];
      if (matter.time) matter.time[p] = opaque_depth * seen.time[s];
    }
}

int TileMatter::join(int64_t k, size_t n, float stop) {
  for (size_t pair = 0; pair < job_.pairs.size(); ++pair) {
    const size_t first = joined_groups + 2 * pair;
    const MatterPair a{
        tile_.width, tile_.height, pitch_, {used(n, first), used(n, first + 1)}, job_.pairs[pair]};
    if (a.group[0] || a.group[1]) pair_up(a, of(n, 1));
  }
  JoinArgs j;
  j.group = {used(n, 0), used(n, 1)};
  j.k = static_cast<float>(k), j.front = k == job_.main->view->first_sheet() ? 2 : 0.5f;
  j.width = tile_.width, j.height = tile_.height, j.pitch = pitch_;
  j.combine = job_.combine;
  j.stop = stop, j.depth_at = job_.options->depth_opacity;
  j.pixel = pixel_;
  return loops_.join(j);
}

} // namespace bccsplat
