// SPDX-License-Identifier: Apache-2.0
// The same bits, whoever works and how often.
#include "tests/stability/stability.h"

namespace host {
namespace {

TEST(StabilityDeterminism, FilesPicturesAndValuesDoNotDependOnThreads) {
  const Series s{.nx = 37, .ny = 29, .nz = 31, .nt = 7};
  std::vector<unsigned char> bytes;
  std::vector<float> values, pixels, slab;
  for (const int threads : {1, 2, 3, 8, 1}) {
    const Device device = make_device(threads);
    const Stored stored = store(device, s);
    const std::vector<float> v = values_at(stored.volume, random_points(s, 500));
    const Slice slice = cut_time(stored.volume, 2.6), oblique = cut(stored.volume, 0.5, -0.2, 0.4, 0.6, -12);
    auto camera = sized<bccsplat_camera>();
    ASSERT_OK(
        bccsplat_slice_fit_camera(slice.get(), BCCSPLAT_PROJECTION_PERSPECTIVE, 20, 30, 150, 130, &camera));
    const std::vector<float> p =
        picture(device, slice, {.width = 150, .height = 130, .ramp = {5, 100, 0.3, 1}, .camera = &camera});
    const std::vector<float> g = grid_of(oblique);
    if (bytes.empty()) {
      bytes = stored.file->bytes, values = v, pixels = p, slab = g;
      continue;
    }
    EXPECT_TRUE(bytes == stored.file->bytes) << threads;
    EXPECT_TRUE(values == v) << threads;
    EXPECT_TRUE(pixels == p) << threads;
    EXPECT_EQ(0, std::memcmp(slab.data(), g.data(), slab.size() * sizeof(float))) << threads; // NaNs included
  }
}

TEST(StabilityDeterminism, TilesAndCachesLeaveNoTrace) {
  const Device device = make_device();
  const Series s{.nx = 30, .ny = 28, .nz = 26, .nt = 9};
  const Stored stored = store(device, s);
  std::vector<float> first;
  for (const int32_t tile : {0, 16, 32, 64}) {
    const Slice slice = cut_time(stored.volume, 3.3);
    Shot shot{.width = 97, .height = 83, .ramp = {5, 100, 0.3, 1}};
    shot.options.tile_size = tile;
    const std::vector<float> got = picture(device, slice, shot);
    if (first.empty())
      first = got;
    else
      EXPECT_TRUE(first == got) << tile;
  }
  // Layers made in another order, through a cache that holds hardly anything.
  std::vector<float> forward, backward(9);
  for (int f = 0; f < 9; ++f) forward.push_back(values_at(stored.volume, {14, 13, 12, f + 0.0})[0]);
  auto o = sized<bccsplat_volume_options>();
  o.cache_bytes = 1;
  bccsplat_volume* again = nullptr;
  ASSERT_OK(bccsplat_volume_open_memory(device.get(), stored.file->bytes.data(), stored.file->bytes.size(),
                                        &o, &again));
  const Volume small(again);
  for (int f = 8; f >= 0; --f) backward[f] = values_at(small, {14, 13, 12, f + 0.0})[0];
  EXPECT_EQ(forward, backward);
}

} // namespace
} // namespace host
