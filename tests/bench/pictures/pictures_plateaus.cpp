// SPDX-License-Identifier: Apache-2.0
// Plateaus have no surface that light could show. What a picture has there of light and shade is glitter: the
// kernel's ripple, rounding, and the noise of the data. Measured is the luminance, over the opacity, against
// its mean in a window of plateau pixels; what is shown is of one colour, so that light alone changes it.
#include <algorithm>
#include <cmath>
#include <functional>

#include "tests/bench/paper/paper.h"
#include "tests/bench/pictures/picture_volume.h"
#include "tests/bench/pictures/pictures.h"

namespace bccsplat::bench {
namespace {

// Pixels on either side that a mean is taken of.
constexpr int reach = 5;
// Around a plateau pixel of real data, voxels are of the object and within this share of the range.
constexpr int calm_reach = 2;
constexpr double calm = 0.12;
// Pixels per voxel of pictures that are lit by the kernel's own gradient.
constexpr double small = 0.75;

struct Plateau {
  int width = 0, height = 0;
  std::vector<char> inside; // per pixel
};

double pixel_luminance(const float* rgba) {
  const double alpha = std::max(static_cast<double>(rgba[3]), 1e-6);
  return (0.2126 * rgba[0] + 0.7152 * rgba[1] + 0.0722 * rgba[2]) / alpha;
}

struct Glitter {
  double rms = 0, share = 0; // of the picture's pixels
};

Glitter glitter(const Drawn& picture, const Plateau& plateau) {
  const auto inside = [&](int x, int y) {
    return x >= 0 && y >= 0 && x < plateau.width && y < plateau.height &&
           plateau.inside[static_cast<size_t>(y) * plateau.width + x];
  };
  double squares = 0, count = 0;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      if (!inside(x, y)) continue;
      double sum = 0, n = 0;
      for (int v = y - reach; v <= y + reach; ++v)
        for (int u = x - reach; u <= x + reach; ++u)
          if (inside(u, v)) sum += pixel_luminance(picture.at(u, v)), n += 1;
      const double off = pixel_luminance(picture.at(x, y)) - sum / n;
      squares += off * off, count += 1;
    }
  return {count > 0 ? std::sqrt(squares / count) : 0, count / (1.0 * picture.width * picture.height)};
}

// Pixels of the view from the front at which `test(x, y)`, in voxels, holds.
Plateau plateau_of(const FitSource& s, const std::function<bool(double, double)>& test, double pixels = 2) {
  Plateau p{static_cast<int>(pixels * s.dims[0]), static_cast<int>(pixels * s.dims[1]), {}};
  for (int j = 0; j < p.height; ++j)
    for (int i = 0; i < p.width; ++i)
      p.inside.push_back(test((i + 0.5) / pixels - 0.5, s.dims[1] - 1 - ((j + 0.5) / pixels - 0.5)));
  return p;
}

// Of a real set cut at z: the voxels around are of the object, all nearly alike.
Plateau calm_pixels(const FitSource& s, double cut, double middle, double range) {
  const std::vector<float> v = s.frame(0);
  return plateau_of(s, [&](double x, double y) {
    double low = 1e30, high = -1e30;
    for (int c = -calm_reach; c <= 0; ++c)
      for (int b = -calm_reach; b <= calm_reach; ++b)
        for (int a = -calm_reach; a <= calm_reach; ++a) {
          const double px = std::round(x) + a, py = std::round(y) + b, pz = cut + c;
          if (px < 0 || py < 0 || px >= s.dims[0] || py >= s.dims[1] || pz < 0) return false;
          const auto at = static_cast<size_t>(px + s.dims[0] * (py + s.dims[1] * pz));
          low = std::min(low, static_cast<double>(v[at])), high = std::max(high, static_cast<double>(v[at]));
        }
    return low > middle && high - low <= calm * range;
  });
}

struct Case {
  std::string name;
  FitSource source;
  double middle, cut;
  Plateau of_cut, of_haze, of_small; // no pixels: not drawn
};

std::vector<Case> cases(const std::string& folder, bool quick) {
  std::vector<Case> list;
  for (const bool ball : {true, false})
    for (const SourceType type : {SourceType::u8, SourceType::f32}) {
      Body body{.ball = ball, .n = quick ? 40u : 64u, .edge = 3, .type = type};
      if (type == SourceType::f32) body.inside = 1;
      FitSource source = body.source();
      const double cut = std::floor(0.5 * body.n);
      // Five voxels inside the edge, where kernels do not reach it.
      const auto inside = [&](double x, double y) { return body.outside(x, y, cut) < -1.5 - 5; };
      Plateau of_cut = plateau_of(source, inside);
      list.push_back({concat(ball ? "ball" : "box", type == SourceType::u8 ? ", u8" : ", f32"), source,
                      0.5 * body.inside, cut, of_cut, ball ? Plateau{} : of_cut,
                      plateau_of(source, inside, small)});
    }
  if (folder.empty()) return list;
  for (const PaperSet& set : paper_sets())
    for (const auto& [name, middle] : {std::pair("tooth", 120.0), std::pair("engine", 75.0)}) {
      if (std::string(set.name) != name) continue;
      auto source = load_paper_set(set, folder);
      if (!source) continue;
      const double cut = std::floor(0.5 * source->dims[2]);
      Plateau calm_of_cut = calm_pixels(*source, cut, middle, 255);
      list.push_back({name, std::move(*source), middle, cut, std::move(calm_of_cut), {}, {}});
    }
  return list;
}

const char* quality_word(int32_t quality) {
  static constexpr const char* names[] = {"", "draft", "normal", "fine", "best"};
  return names[quality];
}

} // namespace

void pictures_plateaus(const std::string& folder, const Report& report) {
  const Handle<bccsplat_device> device = make_api_device(2);
  std::vector<Row> rows;
  for (const Case& c : cases(folder, report.quick)) {
    const PictureVolume volume(device.get(), c.source);
    for (const int32_t quality :
         {BCCSPLAT_QUALITY_DRAFT, BCCSPLAT_QUALITY_NORMAL, BCCSPLAT_QUALITY_FINE, BCCSPLAT_QUALITY_BEST}) {
      const auto measure = [&](const char* what, const Shot& shot, const Plateau& plateau) {
        if (plateau.inside.empty()) return;
        Shot any = shot;
        any.any_gradient = true;
        const Glitter g = glitter(volume.draw(shot), plateau), before = glitter(volume.draw(any), plateau);
        rows.push_back({word("what", c.name), word("shown", what), word("quality", quality_word(quality)),
                        figure("luminance noise, every gradient lit", before.rms, 5),
                        figure("by the defaults", g.rms, 5), figure("of the pixels", g.share, 3)});
      };
      Shot shot{.quality = quality, .cut = c.cut, .white = 0.95, .middle = c.middle};
      measure("cut, opaque", shot, c.of_cut);
      shot.perspective = true;
      measure("cut, opaque, perspective", shot, c.of_cut);
      shot.perspective = false, shot.pixels = small;
      measure("cut, opaque, small", shot, c.of_small);
      shot.pixels = 2;
      shot.white = 0.03, shot.cut.reset();
      measure("whole, haze", shot, c.of_haze);
    }
  }
  report.table("light and shade where the field is constant", rows);
}

} // namespace bccsplat::bench
