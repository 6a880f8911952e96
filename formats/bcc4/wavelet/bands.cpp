// SPDX-License-Identifier: Apache-2.0
#include "formats/bcc4/wavelet/bands.h"

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
    : width_(box.size[0] + 2 * rim), height_(box.size[1] + 2 * rim), depth_(box.size[2] + 2 * rim),
      values_(width_ * height_ * depth_ * (layers + rim) + 2 * width_),
      filled_(height_ * depth_ * (layers + rim)) {}

} // namespace bccsplat
