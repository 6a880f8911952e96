// SPDX-License-Identifier: Apache-2.0
#include "splat/tile/tile_memory.h"

#include <algorithm>

#include "base/grid.h"

namespace bccsplat {

void SheetMemory::size_planes(const SplatPlan& plan, const PlannedTile& tile) {
  width = tile.width + 2 * plan.sheets.border, height = tile.height + 2 * plan.sheets.border;
  ring_width = tile.ring_width, ring_height = tile.ring_height;
  plane_pitch = (width + 15) / 16 * 16 + 16;
  const size_t floats = plane_floats();
  zero_plane.reserve(floats);
  std::fill_n(zero_plane.data(), floats, 0.0f);
}

void SheetMemory::prepare(const SplatPlan& plan, const PlannedTile& tile, bool gradients) {
  size_planes(plan, tile);
  // Whole vectors are extracted, which must not reach into the next row.
  ring_pitch = (ring_width + 15) / 16 * 16 + 2 * plan.ring.spare_columns;
  ring_start = static_cast<size_t>(plan.ring.spare_rows * ring_pitch + plan.ring.spare_columns) * 4;
  group_floats = plane_size(ring_pitch, ring_height + 2 * plan.ring.spare_rows) * 4 + 64;
  sample_pitch = (ring_width + 15) / 16 * 16 + 16;
  const size_t sample_floats = plane_size(sample_pitch, ring_height) + 16;
  const auto clear = [&](AlignedArray<float>& a) {
    a.reserve(sample_floats);
    std::fill_n(a.data(), sample_floats, 0.0f);
  };
  if (plan.raise.depth_taps > 0)
    for (auto& sheet : stack.slot) clear(sheet);
  if (plan.raise.taps > 0) {
    clear(samples);
    const size_t room = static_cast<size_t>(sample_pitch + 32) * raise_rows;
    scratch.reserve(room);
    std::fill_n(scratch.data(), room, 0.0f); // vectors read beside a row, where numbers must be
  }
  for (size_t q = 0; q < (gradients ? 4u : 1u); ++q) {
    const size_t floats = group_floats * plan.ring.groups + 64;
    ring[q].reserve(floats);
    std::fill_n(ring[q].data(), floats, 0.0f);
    for (auto& sheet : plane.slot) {
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

void TileMemory::prepare_pixels(const PlannedTile& tile, size_t holes) {
  pixel_pitch = (tile.width + 15) / 16 * 16;
  const size_t floats = plane_size(pixel_pitch, tile.height);
  pixels.reserve(pixel_planes * floats);
  std::fill_n(pixels.data(), pixel_planes * floats, 0.0f);
  hole.reserve(holes * floats);
}

TilePixels finished_tile(const PlannedTile& tile, int pitch, const PixelPlanes& pixel, const DeepTile* deep) {
  return {tile.x,     tile.y,      tile.width,  tile.height, pitch,      pixel.red, pixel.green,
          pixel.blue, pixel.alpha, pixel.depth, pixel.value, pixel.time, deep,      {}};
}

} // namespace bccsplat
