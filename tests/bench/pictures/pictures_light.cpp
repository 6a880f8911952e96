// SPDX-License-Identifier: Apache-2.0
// A smooth object far from the base is lit alike by every quality, whether its pixels are smaller or larger
// than the lattice's distances, and from every level: luminance over opacity of one colour, its mean and what
// light and shade make of it.
#include <algorithm>
#include <cmath>
#include <tuple>

#include "tests/bench/pictures/picture_volume.h"
#include "tests/bench/pictures/pictures.h"

namespace bccsplat::bench {
namespace {

// Voxels over which a blob of value 1 falls by a standard deviation: its gradients are at most 0.01 of it.
constexpr double width = 70;

FitSource blob(uint32_t n) {
  FitSeries s{{n, n, n, 1}, {}};
  const double c = 0.5 * (n - 1.0);
  for (uint32_t z = 0; z < n; ++z)
    for (uint32_t y = 0; y < n; ++y)
      for (uint32_t x = 0; x < n; ++x) {
        const double square = (x - c) * (x - c) + 1.3 * (y - c) * (y - c) + (z - c) * (z - c);
        s.values.push_back(static_cast<float>(std::exp(-0.5 * square / (width * width))));
      }
  return source_of<float>(s, SourceType::f32, 1, "");
}

struct Luminance {
  double mean = 0, shade = 0; // over pixels that are seen; RMS about the mean
};

Luminance luminance(const Drawn& picture) {
  double count = 0, sum = 0, squares = 0;
  for (size_t p = 0; p < picture.rgba.size(); p += 4) {
    const double alpha = picture.rgba[p + 3];
    if (alpha < 0.1) continue;
    const double l = picture.rgba[p + 1] / alpha; // of grey
    count += 1, sum += l, squares += l * l;
  }
  const double mean = sum / std::max(count, 1.0);
  return {mean, std::sqrt(std::max(squares / std::max(count, 1.0) - mean * mean, 0.0))};
}

} // namespace

void pictures_light(const std::string&, const Report& report) {
  const Handle<bccsplat_device> device = make_api_device(2);
  const PictureVolume volume(device.get(), blob(report.quick ? 48 : 96), 1);
  std::vector<Row> rows;
  for (const bool perspective : {false, true})
    for (const double pixels : {2.0, 0.75})
      for (const auto& [name, quality, level] :
           {std::tuple("draft", BCCSPLAT_QUALITY_DRAFT, 0u),
            std::tuple("normal", BCCSPLAT_QUALITY_NORMAL, 0u),
            std::tuple("normal", BCCSPLAT_QUALITY_NORMAL, 1u), std::tuple("fine", BCCSPLAT_QUALITY_FINE, 0u),
            std::tuple("best", BCCSPLAT_QUALITY_BEST, 0u)}) {
        Shot shot{.quality = quality, .cut = {}, .white = 0.05, .middle = 0.8};
        shot.pixels = pixels, shot.perspective = perspective, shot.level = level;
        const Luminance l = luminance(volume.draw(shot));
        rows.push_back({word("view", perspective ? "perspective" : "orthographic"),
                        figure("pixels a voxel", pixels, 2), word("quality", name), figure("level", level, 0),
                        figure("mean luminance", l.mean, 4), figure("light and shade", l.shade, 4)});
      }
  report.table("the light of a smooth object far from the base", rows);
}

} // namespace bccsplat::bench
