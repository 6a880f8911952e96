// SPDX-License-Identifier: Apache-2.0
#include "formats/bcc4/wavelet/bands.h"

#include <algorithm>

namespace bccsplat {
namespace {

constexpr int directions = 8;

bool is_direction(const Halvings& shape, int level, int direction) {
  for (int a = 0; a < 3; ++a)
    if ((direction >> a & 1) && !shape.halves(a, level)) return false;
  return true;
}

BandBox band_box(const Halvings& shape, int level, int direction) {
  BandBox box{level, direction, {}, {}};
  for (int a = 0; a < 3; ++a) {
    const bool fine = direction >> a & 1;
    const int coarse = shape.kept(a, level);
    box.begin[a] = fine ? coarse : 0;
    box.size[a] = fine ? shape.kept(a, level - 1) - coarse : coarse;
  }
  return box;
}

} // namespace

std::vector<BandBox> bands_of(const Halvings& shape) {
  std::vector<BandBox> bands{band_box(shape, shape.levels(), 0)};
  for (int level = shape.levels(); level >= 1; --level)
    for (int direction = 1; direction < directions; ++direction)
      if (is_direction(shape, level, direction)) bands.push_back(band_box(shape, level, direction));
  return bands;
}

BandMagnitudes::BandMagnitudes(const BandBox& box, int layers)
    : width_(std::max(box.size[0], 0) + 2 * rim), height_(std::max(box.size[1], 0) + 2 * rim),
      depth_(std::max(box.size[2], 0) + 2 * rim), layers_(layers + rim) {}

void BandMagnitudes::place(uint16_t* values, uint8_t* flags) {
  values_ = values, rows_ = flags, planes_ = flags + height_ * depth_ * layers_;
}

void BandMagnitudes::clear() {
  for (size_t plane = 0; plane < depth_ * layers_; ++plane) {
    if (!planes_[plane]) continue;
    for (size_t row = plane * height_; row < (plane + 1) * height_; ++row)
      if (rows_[row]) std::fill_n(values_ + row * width_, width_, uint16_t{0});
    std::fill_n(rows_ + plane * height_, height_, uint8_t{0});
    planes_[plane] = 0;
  }
}

} // namespace bccsplat
