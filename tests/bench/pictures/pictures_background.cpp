// SPDX-License-Identifier: Apache-2.0
// Where nothing is there is nothing to be seen: the field beside an edge, and the opacity of the default
// picture where a ray meets nothing but air, three voxels around it included. Of real sets air is what their
// look says.
#include <algorithm>
#include <cmath>

#include "tests/bench/paper/paper.h"
#include "tests/bench/pictures/picture_volume.h"
#include "tests/bench/pictures/pictures.h"

namespace bccsplat::bench {
namespace {

// Voxels beside an edge that are left out.
constexpr double beside = 3;

struct Seen {
  double most = 0, share = 0; // of opacity; of the pixels, those that are seen
  double background = 0;      // of the pixels, those that meet air alone
};

// background: per pixel of the view from the front.
Seen seen_of(const Drawn& picture, const std::vector<char>& background) {
  Seen s;
  for (size_t p = 0; p < background.size(); ++p) {
    if (!background[p]) continue;
    const auto alpha = static_cast<double>(picture.rgba[4 * p + 3]);
    s.background += 1, s.most = std::max(s.most, alpha), s.share += alpha > 1.0 / 255 ? 1 : 0;
  }
  s.share /= std::max(s.background, 1.0), s.background /= static_cast<double>(background.size());
  return s;
}

// Largest difference from air beyond the edge, as a share of the value inside.
double largest_outside(const PictureVolume& volume, const Body& body) {
  std::vector<std::array<double, 4>> points;
  for (double z = 0; z < body.n - 1; z += 1.37)
    for (double y = 0; y < body.n - 1; y += 1.21)
      for (double x = 0; x < body.n - 1; x += 1.13)
        if (body.outside(x, y, z) > 0.5 * body.edge + beside) points.push_back({x, y, z, 0});
  double most = 0;
  for (const float v : volume.field(points)) most = std::max(most, std::fabs(static_cast<double>(v)));
  return most / body.inside;
}

std::vector<char> around_body(const Body& body) {
  std::vector<char> pixels;
  const double c = 0.5 * (body.n - 1.0);
  for (uint32_t j = 0; j < 2 * body.n; ++j)
    for (uint32_t i = 0; i < 2 * body.n; ++i)
      pixels.push_back(body.outside(0.5 * (i - 0.5), 0.5 * (j - 0.5), c) > 0.5 * body.edge + beside);
  return pixels;
}

// Pixels whose columns of voxels, and those up to three to the sides, are all within `empty`.
std::vector<char> around_set(const FitSource& s, const std::array<double, 2>& empty) {
  const std::vector<float> v = s.frame(0);
  const auto width = static_cast<int>(s.dims[0]), height = static_cast<int>(s.dims[1]);
  std::vector<char> column(size_t{s.dims[0]} * s.dims[1], 1);
  for (size_t n = 0; n < v.size(); ++n)
    if (const auto x = static_cast<double>(v[n]); x < empty[0] || x > empty[1]) column[n % column.size()] = 0;
  std::vector<char> pixels;
  for (int j = 0; j < 2 * height; ++j)
    for (int i = 0; i < 2 * width; ++i) {
      bool air = true;
      for (int b = -3; b <= 3; ++b)
        for (int a = -3; a <= 3; ++a) {
          const int x = std::clamp(i / 2 + a, 0, width - 1),
                    y = std::clamp(height - 1 - j / 2 + b, 0, height - 1);
          air = air && column[static_cast<size_t>(y) * s.dims[0] + static_cast<size_t>(x)];
        }
      pixels.push_back(air);
    }
  return pixels;
}

} // namespace

void pictures_background(const std::string& folder, const Report& report) {
  const Handle<bccsplat_device> device = make_api_device(2);
  std::vector<Row> rows;
  const auto add = [&](const std::string& name, const PictureVolume& volume,
                       const std::vector<char>& background, const std::string& field) {
    const Seen s = seen_of(volume.draw({}), background);
    rows.push_back({word("what", name), word("field beside it, of the value inside", field),
                    figure("largest opacity", s.most, 4), figure("of the background seen", s.share, 4),
                    figure("background, of the pixels", s.background, 3)});
  };
  for (const double edge : {0.0, 1.0, 3.0})
    for (const SourceType type : {SourceType::u8, SourceType::f32}) {
      Body body{.n = report.quick ? 40u : 64u, .edge = edge, .type = type};
      if (type == SourceType::f32) body.inside = 1;
      const PictureVolume volume(device.get(), body.source());
      add(concat("ball, ", type == SourceType::u8 ? "u8" : "f32", ", edge of ", edge, " voxels"), volume,
          around_body(body), number(largest_outside(volume, body), 5));
    }
  if (!folder.empty())
    for (const PaperSet& set : paper_sets()) {
      if (set.series || (report.quick && std::string(set.name) != "tooth")) continue;
      const auto source = load_paper_set(set, folder);
      if (!source || source->type != SourceType::u8) continue;
      const PictureVolume volume(device.get(), *source);
      add(set.name, volume, around_set(*source, volume.empty()), "");
    }
  report.table("the background of the default picture, from the front", rows);
}

} // namespace bccsplat::bench
