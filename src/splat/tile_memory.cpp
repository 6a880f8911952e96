#include "splat/tile_memory.h"

#include <algorithm>

namespace bccsplat {

void TileMemory::prepare(const SplatPlan& plan, int tile_width, int tile_height, bool gradients) {
  width = tile_width + 2 * plan.border, height = tile_height + 2 * plan.border;
  // Whole vectors are extracted: they must not reach into the next row.
  ring_pitch = (width + 15) / 16 * 16 + 2 * plan.spare_columns;
  ring_start = static_cast<size_t>(plan.spare_rows * ring_pitch + plan.spare_columns) * 4;
  group_floats = static_cast<size_t>(ring_pitch) * static_cast<size_t>(height + 2 * plan.spare_rows) * 4 + 64;
  plane_pitch = (width + 15) / 16 * 16 + 16;
  for (size_t q = 0; q < (gradients ? 4u : 1u); ++q) {
    const size_t floats = group_floats * static_cast<size_t>(plan.groups) + 64;
    ring[q].reserve(floats);
    std::fill_n(ring[q].data(), floats, 0.0f);
    for (auto& sheet : plane) {
      const size_t plane_floats =
          static_cast<size_t>(plane_pitch) * static_cast<size_t>(height) + 2 * plane_margin + 16;
      sheet[q].reserve(plane_floats);
      std::fill_n(sheet[q].data(), plane_floats, 0.0f);
      if (q > 0) continue;
      zero_plane.reserve(plane_floats);
      std::fill_n(zero_plane.data(), plane_floats, 0.0f);
    }
  }
  pixel_pitch = (tile_width + 15) / 16 * 16;
  const size_t pixel_floats = static_cast<size_t>(pixel_pitch) * static_cast<size_t>(tile_height);
  pixels.reserve(pixel_planes * pixel_floats);
  std::fill_n(pixels.data(), pixel_planes * pixel_floats, 0.0f);
  hole.reserve(pixel_floats);

  size_t count = 1;
  while (count < static_cast<size_t>(plan.longest) + 2) count *= 2;
  if (bins.size() != count + 1) bins = std::vector<AlignedArray<SplatRecord>>(count + 1);
  bin_end.resize(count + 1);
  for (size_t b = 0; b <= count; ++b) {
    bins[b].reserve(64);
    bin_end[b] = bins[b].data();
  }
}

} // namespace bccsplat
