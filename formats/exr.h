// OpenEXR output: scanlines, ZIP, 32-bit float.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace bccsplat {

// One channel inside an interleaved or planar image; row 0 is the top.
struct ExrChannel {
  std::string name; // "R", "depth.Z", ...
  const float* pixels = nullptr;
  size_t pixel_floats = 1; // distance of neighbouring pixels
  size_t row_floats = 0;   // distance of neighbouring rows
};

struct ExrOptions {
  bool overwrite = false;
  std::array<int, 2> frames_per_second{0, 0};                  // numerator, denominator; 0: not written
  std::vector<std::pair<std::string, std::string>> attributes; // text, such as "bccsplat/kernel"
};

// Throws file_exists, permission_denied, no_space, io_error; missing_feature when built without image
// support.
void write_exr(const std::string& path, int width, int height, std::span<const ExrChannel> channels,
               const ExrOptions& options);

} // namespace bccsplat
