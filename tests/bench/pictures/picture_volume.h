// SPDX-License-Identifier: Apache-2.0
// A source as a host of the C API stores it and draws it, all by the defaults.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "tests/bench/fit/fit_source.h"
#include "tests/bench/scale/scale_host.h"

namespace bccsplat::bench {

// A ball or a box in air 0, of value `inside`, whose edge falls linearly over `edge` voxels (0: at once), in
// the middle of n^3 voxels.
struct Body {
  bool ball = true;
  uint32_t n = 64;
  double edge = 3, inside = 200;
  SourceType type = SourceType::u8;
  [[nodiscard]] double radius() const { return 0.34 * n; }
  // How far a point lies outside the middle of the edge, in voxels.
  [[nodiscard]] double outside(double x, double y, double z) const;
  [[nodiscard]] FitSource source() const;
};

// The picture of a volume's first frame, or of a part of it, from a direction.
struct Shot {
  int32_t quality = BCCSPLAT_QUALITY_NORMAL;
  int32_t mode = BCCSPLAT_MODE_COMPOSITE;
  std::optional<double> cut;   // samples z <= this only
  std::optional<double> white; // one colour, of this opacity from the middle of the values on; none: the look
  double middle = 0;
  double ramp = 0;        // not 0: opacity rises from air to this value, as --range of the tool has it
  bool from_front = true; // against z, x to the right and y up; else the fitted view
  double pixels = 2;      // a voxel, from the front; in perspective at the last voxels that are drawn
  bool perspective = false;
  uint32_t level = 0;        // of the volume
  bool any_gradient = false; // every gradient is lit as a surface's
};

struct Drawn {
  int width = 0, height = 0;
  std::vector<float> rgba; // linear, premultiplied
  [[nodiscard]] const float* at(int x, int y) const {
    return rgba.data() + 4 * (static_cast<size_t>(y) * width + x);
  }
};

class PictureVolume {
 public:
  PictureVolume(bccsplat_device* device, const FitSource& source, uint32_t levels = 0);
  [[nodiscard]] Drawn draw(const Shot& shot) const;
  // The field at points in index space.
  [[nodiscard]] std::vector<float> field(const std::vector<std::array<double, 4>>& points) const;
  [[nodiscard]] bccsplat_look look() const; // of composites; also its empty values and its iso value

 private:
  bccsplat_device* device_;
  std::array<uint32_t, 4> dims_;
  std::vector<unsigned char> file_; // the volume reads from it
  Handle<bccsplat_volume> volume_;
};

} // namespace bccsplat::bench
