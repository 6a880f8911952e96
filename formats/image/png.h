// SPDX-License-Identifier: Apache-2.0
// Writes PNG files of 8-bit sRGB.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>

namespace bccsplat {

struct PngOptions {
  bool overwrite = false;
  std::optional<std::array<double, 3>> background; // linear RGB; none: straight alpha
};

// `rgba` is linear and premultiplied, 4 floats per pixel, rows row_floats apart, row 0 at the top. Throws
// file_exists, permission_denied, no_space, io_error; missing_feature when built without image support.
void write_png(const std::string& path, int width, int height, const float* rgba, size_t row_floats,
               const PngOptions& options);

// Applies the sRGB transfer curve to a linear value; values outside [0, 1] and NaN are clamped.
[[nodiscard]] unsigned char srgb_byte(double linear);

} // namespace bccsplat
