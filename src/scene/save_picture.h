// SPDX-License-Identifier: Apache-2.0
// Pictures into files.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/files.h"
#include "base/progress.h"
#include "draw/deep.h"
#include "draw/image.h"
#include "view/camera.h"

namespace bccsplat {

enum class PictureFormat : uint8_t { png = 1, exr = 2, deep_exr = 3 };

// What is written beside the pixels. PNG takes the background alone; EXR all but that.
struct PictureNotes {
  std::optional<std::array<double, 3>> background; // linear RGB; none: straight alpha
  std::array<int, 2> frames_per_second{0, 0};      // numerator, denominator; 0: not written
  double exposure_seconds = 0;                     // 0: not written
  std::string comments;                            // empty: not written
  std::optional<WorldCamera> camera;
  std::vector<std::pair<std::string, std::string>> attributes; // text, such as "bccsplat/kernel"
};

// Writes the picture into a sink, which is not committed yet. deep: of format deep_exr. name: for error
// texts. Throws cancelled, io_error, unsupported (built without image files).
void save_picture(ByteSink& sink, const std::string& name, PictureFormat format, const Image& image,
                  const DeepImage* deep, const PictureNotes& notes, Progress& progress);

} // namespace bccsplat
