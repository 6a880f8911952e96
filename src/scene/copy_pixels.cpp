// SPDX-License-Identifier: Apache-2.0
#include "scene/copy_pixels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "base/half.h"
#include "formats/image/png.h"

namespace bccsplat {
namespace {

constexpr size_t codes = 256; // of a byte
constexpr uint32_t last_code = codes - 1;
constexpr size_t parts = 1024; // of the range from 0 to 1

// The sRGB curve as the least float of each byte, and the bytes where a thousandth of the range begins.
class SrgbSteps {
 public:
  SrgbSteps() {
    for (size_t b = 1; b < codes; ++b) {
      float low = least_[b - 1], high = 1; // the curve rises
      while (std::nextafter(low, 1.0f) < high) {
        const float middle = 0.5f * (low + high);
        (srgb_byte(static_cast<double>(middle)) >= b ? high : low) = middle;
      }
      least_[b] = high;
    }
    least_[codes] = HUGE_VALF;
    for (size_t n = 0; n < first_.size(); ++n)
      first_[n] = srgb_byte(static_cast<double>(n) / static_cast<double>(first_.size()));
  }
  [[nodiscard]] uint8_t at(float linear) const {
    if (!(linear > 0)) return 0;
    if (linear >= 1) return last_code;
    size_t b = first_[static_cast<size_t>(linear * static_cast<float>(first_.size()))];
    while (linear >= least_[b + 1]) ++b;
    return static_cast<uint8_t>(b);
  }

 private:
  std::array<float, codes + 1> least_{};
  std::array<uint8_t, parts> first_{};
};

const SrgbSteps& srgb_steps() {
  static const SrgbSteps steps;
  return steps;
}

void code_row(const float* from, int width, bool premultiplied, uint8_t* to) {
  const SrgbSteps& steps = srgb_steps();
  for (int x = 0; x < width; ++x, from += 4, to += 4) {
    const float alpha = std::isnan(from[3]) ? 0 : std::clamp(from[3], 0.0f, 1.0f);
    const auto opacity = static_cast<uint32_t>(std::lround(last_code * alpha));
    for (size_t c = 0; c < 3; ++c) {
      const uint32_t straight = alpha > 0 ? steps.at(from[c] / alpha) : 0u;
      to[c] =
          static_cast<uint8_t>(premultiplied ? (straight * opacity + last_code / 2) / last_code : straight);
    }
    to[3] = static_cast<uint8_t>(opacity);
  }
}

} // namespace

uint8_t quick_srgb_byte(float linear) { return srgb_steps().at(linear); }

void copy_pixels(const Plane& plane, int width, int height, PixelFormat format, std::byte* to,
                 std::ptrdiff_t row_bytes, Tasks* tasks) {
  const size_t numbers = static_cast<size_t>(width) * plane.components;
  const auto copy_row = [&](uint64_t row) {
    const float* const from = plane.at(0, static_cast<int>(row));
    std::byte* const out = to + static_cast<std::ptrdiff_t>(row) * row_bytes;
    switch (format) {
    case PixelFormat::f32:
      std::memcpy(out, from, numbers * sizeof(float));
      break;
    case PixelFormat::f16:
      std::transform(from, from + numbers, reinterpret_cast<uint16_t*>(out), float_to_half);
      break;
    case PixelFormat::srgb8:
    case PixelFormat::srgb8_premultiplied:
      code_row(from, width, format == PixelFormat::srgb8_premultiplied, reinterpret_cast<uint8_t*>(out));
    }
  };
  const auto rows = static_cast<uint64_t>(height);
  if (tasks) return tasks->parallel_for(rows, copy_row);
  for (uint64_t row = 0; row < rows; ++row) copy_row(row);
}

} // namespace bccsplat
