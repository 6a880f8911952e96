// SPDX-License-Identifier: Apache-2.0
#include "scene/copy_pixels.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "formats/image/png.h"

namespace bccsplat::test {
namespace {

TEST(CopyPixels, TheQuickCurveIsTheSlowOne) {
  const auto check = [](float x) { ASSERT_EQ(quick_srgb_byte(x), srgb_byte(static_cast<double>(x))) << x; };
  for (uint32_t bits = std::bit_cast<uint32_t>(1e-6f); bits < std::bit_cast<uint32_t>(1.0f); bits += 997)
    check(std::bit_cast<float>(bits));
  for (int b = 1; b < 256; ++b) { // where a byte begins, and just before
    float low = 0, high = 1;
    while (std::nextafter(low, 1.0f) < high) {
      const float middle = 0.5f * (low + high);
      (srgb_byte(static_cast<double>(middle)) >= b ? high : low) = middle;
    }
    check(low), check(high);
  }
  for (const float x : {0.0f, -1.0f, 1.0f, 2.0f, NAN, 0x1.fffffep-1f, 1e-30f, INFINITY}) check(x);
}

TEST(CopyPixels, RowsMayRunUpAndBeApart) {
  constexpr int width = 5, height = 3;
  ImageStorage image(width, height, true);
  for (size_t p = 0; p < image.depth.size(); ++p) image.depth[p] = static_cast<float>(p);
  Tasks tasks(2);
  std::vector<float> out(height * 7, -1.0f);
  copy_pixels(image.image.depth, width, height, PixelFormat::f32,
              reinterpret_cast<std::byte*>(out.data() + 2 * 7), -7 * 4, &tasks);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < 7; ++x)
      EXPECT_EQ(out[static_cast<size_t>(7 * (height - 1 - y) + x)],
                x < width ? static_cast<float>(width * y + x) : -1.0f);
}

} // namespace
} // namespace bccsplat::test
