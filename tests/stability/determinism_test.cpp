// SPDX-License-Identifier: Apache-2.0
// The same bits, whoever works and how often.
#include "tests/stability/stability.h"
#include "tests/support/emulated.h"

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

// Bytes, which are held as codes: bricks of a small thing that moves stand beside air.
TEST(StabilityDeterminism, BytesDoNotDependOnThreads) {
  constexpr uint32_t nx = 48, ny = 40, nz = 44, nt = 24;
  std::vector<uint8_t> source;
  for (uint32_t t = 0; t < nt; ++t)
    for (uint32_t z = 0; z < nz; ++z)
      for (uint32_t y = 0; y < ny; ++y)
        for (uint32_t x = 0; x < nx; ++x) {
          const double dx = x - 14.0 - 0.8 * t, dy = y - 20.0 - 6 * std::sin(0.25 * t), dz = z - 22.0;
          source.push_back(
              static_cast<uint8_t>(std::lround(255 * std::exp(-(dx * dx + dy * dy + dz * dz) / 32))));
        }
  for (const auto& [coding, bound] :
       {std::pair{BCCSPLAT_STORE_SAMPLES, 0.0}, std::pair{BCCSPLAT_STORE_SAMPLES, 0.5},
        std::pair{BCCSPLAT_STORE_WAVELETS, 1.0}}) {
    std::vector<unsigned char> bytes;
    std::vector<float> values;
    for (const int threads : {1, 2, 4}) {
      const Device device = make_device(threads);
      auto o = sized<bccsplat_writer_options>();
      o.dims[0] = nx, o.dims[1] = ny, o.dims[2] = nz, o.dims[3] = nt, o.store = coding, o.abs_error = bound;
      MemoryFile file;
      const Writer writer = make_writer(device, file, o);
      for (uint32_t t = 0; t < nt; ++t) {
        auto box = sized<bccsplat_box>();
        box.type = BCCSPLAT_TYPE_U8, box.data = source.data() + size_t{t} * nx * ny * nz;
        box.dims[0] = nx, box.dims[1] = ny, box.dims[2] = nz;
        ASSERT_OK(bccsplat_writer_add_frame(writer.get(), 0, t, &box, 1));
      }
      ASSERT_OK(bccsplat_writer_finish(writer.get(), nullptr));
      if (bytes.empty()) bytes = file.bytes;
      EXPECT_TRUE(bytes == file.bytes) << coding << ' ' << bound << ' ' << threads;
      bccsplat_volume* opened = nullptr;
      ASSERT_OK(bccsplat_volume_open_memory(device.get(), bytes.data(), bytes.size(), nullptr, &opened));
      const Volume volume(opened);
      std::vector<float> all;
      double worst = 0;
      for (uint32_t t = 0; t < nt; ++t) {
        const std::vector<float> frame = grid_of(cut_time(volume, t));
        for (const float v : frame) {
          worst = larger(worst, std::fabs(v - static_cast<double>(source[all.size()])));
          all.push_back(v);
        }
      }
      EXPECT_LT(worst, bound > 0 ? bound + 1e-4 : 2.5) << coding << ' ' << threads;
      if (values.empty()) values = all;
      EXPECT_TRUE(values == all) << coding << ' ' << bound << ' ' << threads;
    }
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

// Coefficients are made in stretches along z where the cache is small; behind the last sample of a periodic
// axis comes the first one.
TEST(StabilityDeterminism, ValuesDoNotDependOnTheCacheWhereAnAxisIsPeriodic) {
  const Device device = make_device();
  const auto wave = [](double at, double n) { return std::sin(2 * std::numbers::pi * at / n); };
  const Series s{.nx = 6, .ny = 5, .nz = 112, .nt = 56, .field = [&](double x, double y, double z, double t) {
                   return std::cos(0.5 * x) * std::cos(0.3 * y) + 2 * wave(3 * z, 112) + wave(2 * t, 56);
                 }};
  const std::vector<int32_t> lattices{BCCSPLAT_LATTICE_D4STAR, BCCSPLAT_LATTICE_CC};
  for (const int32_t lattice : bccsplat::test::some(lattices, 2)) {
    auto options = options_of(s);
    options.lattice = lattice;
    options.ends = BCCSPLAT_ENDS_PERIODIC, options.periodic_axes = BCCSPLAT_PERIODIC_Z;
    const Stored stored = store(device, s, options);
    std::vector<std::vector<float>> expected;
    for (const uint64_t cache : {uint64_t{1} << 30, uint64_t{1} << 20, uint64_t{1}}) {
      auto o = sized<bccsplat_volume_options>();
      o.cache_bytes = cache;
      bccsplat_volume* opened = nullptr;
      ASSERT_OK(bccsplat_volume_open_memory(device.get(), stored.file->bytes.data(),
                                            stored.file->bytes.size(), &o, &opened));
      const Volume volume(opened);
      // Of a slice across x the series' time is an axis of space, which is periodic as well.
      const std::vector<std::vector<float>> got{grid_of(cut_time(volume, 7.25)),
                                                grid_of(cut(volume, 1, 0, 0, 0, -2.5)),
                                                values_at(volume, random_points(s, 100))};
      if (expected.empty()) expected = got;
      for (size_t i = 0; i < got.size(); ++i)
        EXPECT_TRUE(got[i] == expected[i]) << lattice << ' ' << cache << ' ' << i;
    }
  }
}

} // namespace
} // namespace host
