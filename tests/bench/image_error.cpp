// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/image_error.h"

#include <algorithm>
#include <cmath>

namespace bccsplat::bench {

double ImageError::psnr() const { return -20 * std::log10(rmse); }

ImageError image_error(const Image& picture, const Image& truth, int stride) {
  ImageError e;
  double sum = 0;
  size_t count = 0;
  for (int j = 0; j < truth.height; ++j)
    for (int i = 0; i < truth.width; ++i) {
      const float* a = picture.rgba.at(stride * i + stride / 2, stride * j + stride / 2);
      const float* b = truth.rgba.at(i, j);
      if (a[3] == 0 && b[3] == 0) continue;
      for (size_t c = 0; c < 4; ++c) {
        const double difference = static_cast<double>(a[c]) - b[c];
        sum += difference * difference;
        e.most = std::max(e.most, std::fabs(difference));
      }
      count += 4;
    }
  e.rmse = count ? std::sqrt(sum / static_cast<double>(count)) : 0;
  return e;
}

std::unique_ptr<ImageStorage> area_average(const Image& large, int factor) {
  auto out = std::make_unique<ImageStorage>(large.width / factor, large.height / factor);
  for (int j = 0; j < out->image.height; ++j)
    for (int i = 0; i < out->image.width; ++i)
      for (int c = 0; c < 4; ++c) {
        double sum = 0;
        for (int y = 0; y < factor; ++y)
          for (int x = 0; x < factor; ++x) sum += large.rgba.at(factor * i + x, factor * j + y)[c];
        out->image.rgba.at(i, j)[c] = static_cast<float>(sum / (factor * factor));
      }
  return out;
}

} // namespace bccsplat::bench
