// SPDX-License-Identifier: Apache-2.0
// Writes PNG files of 8-bit sRGB.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>

#include "base/files.h"
#include "base/progress.h"

namespace bccsplat {

struct PngOptions {
  bool overwrite = false;                          // of files
  Progress* progress = nullptr;                    // hears of rows
  std::optional<std::array<double, 3>> background; // linear RGB; none: straight alpha
};

// `rgba` is linear and premultiplied, 4 floats per pixel, rows row_floats apart (any sign), row 0 at the top.
// The sink is not committed; `name` is for error texts. Throws what the sink throws, io_error, cancelled;
// missing_feature when built without image support.
void write_png(ByteSink& sink, const std::string& name, int width, int height, const float* rgba,
               std::ptrdiff_t row_floats, const PngOptions& options);
// Into a file. Throws file_exists, permission_denied, no_space as well.
void write_png(const std::string& path, int width, int height, const float* rgba, std::ptrdiff_t row_floats,
               const PngOptions& options);

// Applies the sRGB transfer curve to a linear value; values outside [0, 1] and NaN are clamped.
[[nodiscard]] unsigned char srgb_byte(double linear);

} // namespace bccsplat
