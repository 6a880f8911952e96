// SPDX-License-Identifier: Apache-2.0
// How far a picture is from the truth.
#pragma once

#include <memory>

#include "draw/image.h"

namespace bccsplat::bench {

// Over red, green, blue and opacity, linear and premultiplied, of the pixels that either picture covers.
struct ImageError {
  double rmse = 0, most = 0;
  [[nodiscard]] double psnr() const; // dB, peak 1
};

// `truth` holds the pixels (stride i + stride / 2, stride j + stride / 2) of the picture.
[[nodiscard]] ImageError image_error(const Image& picture, const Image& truth, int stride = 1);

// Returns the means over blocks of `factor` pixels a side.
[[nodiscard]] std::unique_ptr<ImageStorage> area_average(const Image& large, int factor);

} // namespace bccsplat::bench
