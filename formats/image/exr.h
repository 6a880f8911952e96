// SPDX-License-Identifier: Apache-2.0
// Writes OpenEXR files: scan lines of 32-bit floats with ZIP compression, deep ones with ZIPS.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/files.h"
#include "base/progress.h"

namespace bccsplat {

// One channel inside an interleaved or planar image; row 0 is the top.
struct ExrChannel {
  std::string name; // "R", "depth.Z", ...
  const float* pixels = nullptr;
  size_t pixel_floats = 1;       // distance of neighbouring pixels
  std::ptrdiff_t row_floats = 0; // from a row to the next, any sign
};

// The camera of the picture. Matrices act on row vectors from the left, x' = x M, row by row.
struct ExrView {
  std::array<double, 16> world_to_camera{}; // camera space: x right, y up, z forward (left-handed)
  std::array<double, 16> world_to_ndc{};    // (0, 0) the upper left, (1, 1) the lower right corner
  double screen_width = 1;                  // of the picture at distance 1; 1 without perspective
};

struct ExrOptions {
  bool overwrite = false;                     // of files
  Progress* progress = nullptr;               // hears of rows
  std::array<int, 2> frames_per_second{0, 0}; // numerator, denominator; 0: not written
  double exposure_seconds = 0;                // 0: not written
  std::string comments;                       // empty: not written
  std::optional<ExrView> view;
  std::vector<std::pair<std::string, std::string>> attributes; // text, such as "bccsplat/kernel"
};

// Into a sink, which is not committed; `name` is for error texts. Throws what the sink throws, io_error,
// cancelled; missing_feature when built without image support.
void write_exr(ByteSink& sink, const std::string& name, int width, int height,
               std::span<const ExrChannel> channels, const ExrOptions& options);
// Into a file. Throws file_exists, permission_denied, no_space as well.
void write_exr(const std::string& path, int width, int height, std::span<const ExrChannel> channels,
               const ExrOptions& options);

// Pixel p = y width + x has the samples first[p] .. first[p + 1] - 1 of six floats each: Z, ZBack, A, R, G,
// B, in order of depth and not overlapping ("tidy"). Throws what write_exr throws.
void write_deep_exr(ByteSink& sink, const std::string& name, int width, int height,
                    std::span<const uint64_t> first, std::span<const float> samples,
                    const ExrOptions& options);
void write_deep_exr(const std::string& path, int width, int height, std::span<const uint64_t> first,
                    std::span<const float> samples, const ExrOptions& options);

} // namespace bccsplat
