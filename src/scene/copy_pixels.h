// SPDX-License-Identifier: Apache-2.0
// Pixels of a plane in the forms that hosts show or keep them in.
#pragma once

#include <cstddef>
#include <cstdint>

#include "base/tasks.h"
#include "draw/image.h"

namespace bccsplat {

enum class PixelFormat : uint8_t {
  f32 = 1,
  f16 = 2,
  srgb8 = 3,              // of four components: colours in sRGB, not multiplied by opacity
  srgb8_premultiplied = 4 // the same, each colour times its opacity after coding
};

// Bytes of a number, and numbers are as far from each other as that; 4 of them, or as many as the plane has.
[[nodiscard]] constexpr size_t number_bytes(PixelFormat format) {
  return format == PixelFormat::f32 ? 4 : format == PixelFormat::f16 ? 2 : 1;
}

// Copies width x height pixels, row 0 to `to` and the others row_bytes behind each other, which may be
// negative. tasks: null for the calling thread alone.
void copy_pixels(const Plane& plane, int width, int height, PixelFormat format, std::byte* to,
                 std::ptrdiff_t row_bytes, Tasks* tasks);

// srgb_byte() of formats/image/png.h, by comparing instead of computing.
[[nodiscard]] uint8_t quick_srgb_byte(float linear);

} // namespace bccsplat
