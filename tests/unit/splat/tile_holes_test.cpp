// SPDX-License-Identifier: Apache-2.0
// The holes of a sheet are those that the slice tells at each pixel.
#include <gtest/gtest.h>

#include <vector>

#include "splat/tile/tile_holes.h"

#include "formats/bcc4/read/frame_sources.h"
#include "splat/tile/tile_rays.h"
#include "tests/support/splat_scene.h"
#include "tests/unit/formats/test_data.h"

namespace bccsplat {
namespace {

using namespace test;

// Marks some sites of a ball as holes, a few of them at the ends of the lattice.
void mark_sites(Slice& slice) {
  for (auto& layer : slice.coset)
    for (size_t s = 0; s < layer.brick_slots(); s += 2) {
      auto brick = std::make_shared<Brick>();
      brick->value = layer.brick(s)->value;
      brick->kept = layer.brick(s)->kept;
      brick->hole = std::make_unique<BrickMask>();
      for (size_t row = 0; row < brick_rows; row += 3) (*brick->hole)[row] = 0x0f07;
      layer.set(s, std::move(brick));
    }
  slice.has_holes = true;
}

// Compares every sheet of a view; returns how many sheets had none, some and all of their pixels missing.
std::array<size_t, 3> compare(const Slice& slice, bool perspective) {
  const Camera camera = fit_camera(slice, perspective, 25, 40, 90, 70);
  const SheetView view = make_view(slice, resolve_camera(camera), 90, 70, 0.7);
  PlannedTile tile;
  tile.x = 10, tile.y = 5, tile.width = 61, tile.height = 53;
  constexpr int pitch = 64;
  std::vector<float> planes(ray_planes * pitch * 53);
  PixelPlanes rays;
  (void)make_rays(slice, view, tile, pitch, planes.data(), rays);
  const auto [first, last] = sheet_range(slice, view);
  std::array<size_t, 3> sheets{};
  for (int64_t k = first; k <= last; ++k) {
    const SheetArgs s{
        .segment = {.k = static_cast<float>(k)},
        .tile = {.x = tile.x, .y = tile.y, .width = tile.width, .height = tile.height, .pitch = pitch},
        .pixel = rays};
    std::vector<uint8_t> hole(pitch * 53, 7);
    const Missing missing = find_holes(slice, view, s, hole.data());
    ++sheets[static_cast<size_t>(missing)];
    for (int y = 0; y < tile.height; ++y)
      for (int x = 0; x < tile.width; ++x) {
        const size_t p = y * pitch + x;
        if (!(segment_weight(s, p) > 0)) continue;
        const bool expected = slice.is_hole(view.sample(tile.x + x, tile.y + y, static_cast<double>(k)));
        const bool found = missing == Missing::some ? hole[p] != 0 : missing == Missing::all;
        EXPECT_EQ(found, expected) << k << ' ' << x << ' ' << y;
        if (found != expected) return sheets;
      }
  }
  return sheets;
}

TEST(TileHoles, AreThoseOfTheSites) {
  Slice slice = make_slice({40, 36, 34}, [](double, double, double) { return 1; });
  mark_sites(slice);
  for (const bool perspective : {false, true}) EXPECT_GT(compare(slice, perspective)[1], 10u);
}

TEST(TileHoles, AreThoseOfAMask) {
  const std::vector<std::byte> bytes = masked_file();
  Bench bench;
  const Masks masks(std::make_unique<Bcc4Masks>(Bcc4Reader::open(open_memory_source(bytes)), 1), bench.memory,
                    1 << 20);
  Slice slice = make_slice({20, 11, 9}, [](double, double, double) { return 1; });
  slice.basis = {Vec4{1, 0, 0, 0}, Vec4{0, 1, 0, 0}, Vec4{0, 0, 1, 0}};
  slice.mask = std::make_shared<const SliceMask>(masks, Vec4{}, slice.basis, 1, std::vector{masks.frame(1)});
  slice.has_holes = true;
  for (const bool sites : {false, true}) {
    slice.holes_by_mask = !sites;
    if (sites) mark_sites(slice);
    for (const bool perspective : {false, true}) EXPECT_GT(compare(slice, perspective)[1], 5u);
  }
}

} // namespace
} // namespace bccsplat
