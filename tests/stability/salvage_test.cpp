// SPDX-License-Identifier: Apache-2.0
// What is salvaged of a damaged file is nearly what it was, or no value.
#include "tests/stability/stability.h"

namespace host {
namespace {

// Of a periodic series the ball moves across the ends of x and z.
void expect_salvage(uint32_t periodic_axes) {
  const Device device = make_device();
  const double begin_x = periodic_axes ? 36 : 14, begin_z = periodic_axes ? 1 : 21;
  const Series s{
      .nx = 44, .ny = 38, .nz = 40, .nt = 18, .field = [=](double x, double y, double z, double t) {
        double dx = x - begin_x - 0.8 * t, dz = z - begin_z;
        const double dy = y - 18 - 4 * std::sin(0.3 * t);
        if (periodic_axes) dx = std::remainder(dx, 44.0), dz = std::remainder(dz, 40.0);
        return std::exp(-(dx * dx + dy * dy + dz * dz) / 32);
      }};
  auto options = options_of(s);
  options.periodic_axes = periodic_axes;
  const Stored stored = store(device, s, options);
  size_t damaged = 0;
  for (const double place : {0.1, 0.25, 0.4, 0.55, 0.7, 0.85}) {
    std::vector<unsigned char> bytes = stored.file->bytes;
    constexpr size_t preamble = 192;
    bytes[preamble + static_cast<size_t>(place * static_cast<double>(bytes.size() - preamble))] ^= 0x10;
    auto o = sized<bccsplat_volume_options>();
    o.salvage = 1;
    bccsplat_volume* opened = nullptr;
    ASSERT_OK(bccsplat_volume_open_memory(device.get(), bytes.data(), bytes.size(), &o, &opened));
    const Volume left(opened);
    double worst = 0;
    size_t lost = 0, seen = 0;
    for (double frame = 0; frame < s.nt; frame += 0.5) {
      if (frame > s.nt - 1) break;
      const std::vector<float> was = grid_of(cut_time(stored.volume, frame)),
                               is = grid_of(cut_time(left, frame));
      for (size_t i = 0; i < was.size(); ++i) {
        if (std::isnan(is[i])) {
          ++lost;
          continue;
        }
        ++seen;
        worst = larger(worst, std::fabs(static_cast<double>(is[i]) - static_cast<double>(was[i])));
      }
    }
    EXPECT_LT(worst, 0.08) << place;
    EXPECT_GT(seen, lost);
    damaged += lost > 0 ? 1 : 0;
  }
  EXPECT_GT(damaged, 3u);
}

TEST(StabilitySalvage, WhatIsLeftIsNearlyWhatItWas) { expect_salvage(0); }

TEST(StabilitySalvage, WhatIsLeftBeyondAPeriodicEndIsNearlyWhatItWas) {
  expect_salvage(BCCSPLAT_PERIODIC_X | BCCSPLAT_PERIODIC_Z);
}

} // namespace
} // namespace host
