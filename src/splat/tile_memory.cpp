#include "splat/tile_memory.h"

#include <algorithm>

namespace bccsplat {

void TileMemory::prepare(const SplatPlan& plan, int tile_width, int tile_height, bool gradients) {
  size_planes(plan, tile_width, tile_height);
  prepare_sheets(plan, tile_width, tile_height, gradients);
  prepare_pixels(tile_width, tile_height);
}

void TileMemory::size_planes(const SplatPlan& plan, int tile_width, int tile_height) {
  width = tile_width + 2 * plan.border, height = tile_height + 2 * plan.border;
  plane_pitch = (width + 15) / 16 * 16 + 16;
  const size_t floats = plane_floats();
  zero_plane.reserve(floats);
  std::fill_n(zero_plane.data(), floats, 0.0f);
}

void TileMemory::prepare_sheets(const SplatPlan& plan, int tile_width, int tile_height, bool gradients) {
  size_planes(plan, tile_width, tile_height);
  // Whole vectors are extracted: they must not reach into the next row.
  ring_pitch = (width + 15) / 16 * 16 + 2 * plan.spare_columns;
  ring_start = static_cast<size_t>(plan.spare_rows * ring_pitch + plan.spare_columns) * 4;
  group_floats = static_cast<size_t>(ring_pitch) * static_cast<size_t>(height + 2 * plan.spare_rows) * 4 + 64;
  for (size_t q = 0; q < (gradients ? 4u : 1u); ++q) {
    const size_t floats = group_floats * static_cast<size_t>(plan.groups) + 64;
    ring[q].reserve(floats);
    std::fill_n(ring[q].data(), floats, 0.0f);
    for (auto& sheet : plane) {
      sheet[q].reserve(plane_floats());
      std::fill_n(sheet[q].data(), plane_floats(), 0.0f);
    }
  }
  size_t count = 1;
  while (count < static_cast<size_t>(plan.longest) + 2) count *= 2;
  if (bins.size() != count + 1) bins = std::vector<AlignedArray<SplatRecord>>(count + 1);
  bin_end.resize(count + 1);
  for (size_t b = 0; b <= count; ++b) {
    bins[b].reserve(64);
    bin_end[b] = bins[b].data();
  }
}

void TileMemory::prepare_pixels(int tile_width, int tile_height) {
  pixel_pitch = (tile_width + 15) / 16 * 16;
  const size_t pixel_floats = static_cast<size_t>(pixel_pitch) * static_cast<size_t>(tile_height);
  pixels.reserve(pixel_planes * pixel_floats);
  std::fill_n(pixels.data(), pixel_planes * pixel_floats, 0.0f);
  hole.reserve(pixel_floats);
}

} // namespace bccsplat
