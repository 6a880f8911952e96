// SPDX-License-Identifier: Apache-2.0
// Where nothing is there is nothing to be seen: the field beside an edge, and what pictures of every mode, by
// their defaults, show where a ray meets nothing but air, one or three voxels around it included. Of real
// sets air is what their look says.
#include <algorithm>
#include <cmath>

#include "tests/bench/paper/paper.h"
#include "tests/bench/pictures/picture_volume.h"
#include "tests/bench/pictures/pictures.h"

namespace bccsplat::bench {
namespace {

// Voxels beside an edge that are left out.
constexpr double beside = 3, close_by = 1;

struct Mode {
  const char* name;
  int32_t mode;
  bool ramp = false; // an opacity that rises from air, as a given range of values has it
};
constexpr Mode modes[] = {{"composite", BCCSPLAT_MODE_COMPOSITE},
                          {"composite, ramp", BCCSPLAT_MODE_COMPOSITE, true},
                          {"maximum", BCCSPLAT_MODE_MAXIMUM},
#ifdef BCCSPLAT_BENCH_READERS // with the tool's exposure
                          {"X-ray", BCCSPLAT_MODE_XRAY},
#endif
                          {"isosurface", BCCSPLAT_MODE_ISOSURFACE}};

struct Seen {
  double most = 0, mean = 0; // of 255
  double background = 0;     // of the pixels, those that meet air alone
};

double encoded(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

// What a pixel shows over black on a screen, or its opacity where that is more. The domain of an X-ray is
// opaque.
std::vector<double> shown(const Drawn& picture, bool xray) {
  std::vector<double> values;
  for (size_t at = 0; at < picture.rgba.size(); at += 4) {
    const float* p = picture.rgba.data() + at;
    const double over_black = encoded(std::max({p[0], p[1], p[2]}));
    values.push_back(xray ? over_black : std::max(static_cast<double>(p[3]), over_black));
  }
  return values;
}

// background: per pixel of the view from the front.
Seen seen_of(const std::vector<double>& picture, const std::vector<char>& background) {
  Seen s;
  for (size_t p = 0; p < background.size(); ++p)
    if (background[p])
      s.background += 1, s.mean += 255 * picture[p], s.most = std::max(s.most, 255 * picture[p]);
  s.mean /= std::max(s.background, 1.0), s.background /= static_cast<double>(background.size());
  return s;
}

// Largest difference from air beyond the edge, as a share of the value inside.
double largest_outside(const PictureVolume& volume, const Body& body, double distance) {
  std::vector<std::array<double, 4>> points;
  for (double z = 0; z < body.n - 1; z += 1.37)
    for (double y = 0; y < body.n - 1; y += 1.21)
      for (double x = 0; x < body.n - 1; x += 1.13)
        if (body.outside(x, y, z) > 0.5 * body.edge + distance) points.push_back({x, y, z, 0});
  double most = 0;
  for (const float v : volume.field(points)) most = std::max(most, std::fabs(static_cast<double>(v)));
  return most / body.inside;
}

std::vector<char> around_body(const Body& body, double distance) {
  std::vector<char> pixels;
  const double c = 0.5 * (body.n - 1.0);
  for (uint32_t j = 0; j < 2 * body.n; ++j)
    for (uint32_t i = 0; i < 2 * body.n; ++i)
      pixels.push_back(body.outside(0.5 * (i - 0.5), 0.5 * (j - 0.5), c) > 0.5 * body.edge + distance);
  return pixels;
}

// Pixels whose columns of voxels, and those up to so many to the sides, are all within `empty`, two values.
std::vector<char> around_set(const FitSource& s, const double* empty, double distance) {
  const std::vector<float> v = s.frame(0);
  const int width = s.dims[0], height = s.dims[1];
  const auto reach = static_cast<int>(distance);
  std::vector<char> column(size_t{s.dims[0]} * s.dims[1], 1);
  for (size_t n = 0; n < v.size(); ++n)
    if (const double x = v[n]; x < empty[0] || x > empty[1]) column[n % column.size()] = 0;
  std::vector<char> pixels;
  for (int j = 0; j < 2 * height; ++j)
    for (int i = 0; i < 2 * width; ++i) {
      bool air = true;
      for (int b = -reach; b <= reach; ++b)
        for (int a = -reach; a <= reach; ++a) {
          const int x = std::clamp(i / 2 + a, 0, width - 1),
                    y = std::clamp(height - 1 - j / 2 + b, 0, height - 1);
          air = air && column[static_cast<size_t>(y) * s.dims[0] + x];
        }
      pixels.push_back(air);
    }
  return pixels;
}

// A row for every mode. far, near: the pixels 3 and 1 voxels from what is to be seen. full: the value that a
// ramp ends at.
void add_modes(const std::string& name, const PictureVolume& volume, double full,
               const std::vector<char>& far, const std::vector<char>& near, std::vector<Row>& rows) {
  for (const Mode& m : modes) {
    Shot shot;
    shot.mode = m.mode;
    if (m.ramp) shot.ramp = full, shot.middle = full;
    const std::vector<double> picture = shown(volume.draw(shot), m.mode == BCCSPLAT_MODE_XRAY);
    const Seen away = seen_of(picture, far), close = seen_of(picture, near);
    rows.push_back({word("what", name), word("mode", m.name), figure("most beyond 3 voxels", away.most, 2),
                    figure("mean", away.mean, 3), figure("most beyond 1 voxel", close.most, 2),
                    figure("mean there", close.mean, 3),
                    figure("beyond 3 voxels, of the pixels", away.background, 3)});
  }
}

} // namespace

void pictures_background(const std::string& folder, const Report& report) {
  const Handle<bccsplat_device> device = make_api_device(2);
  std::vector<Row> rows, fields;
  for (const double edge : {0.0, 1.0, 3.0})
    for (const SourceType type : {SourceType::u8, SourceType::f32}) {
      Body body{.n = report.quick ? 40u : 64u, .edge = edge, .type = type};
      if (type == SourceType::f32) body.inside = 1;
      const PictureVolume volume(device.get(), body.source());
      const std::string name =
          concat("ball, ", type == SourceType::u8 ? "u8" : "f32", ", edge of ", edge, " voxels");
      fields.push_back({word("what", name),
                        figure("beyond 3 voxels", largest_outside(volume, body, beside), 5),
                        figure("beyond 1 voxel", largest_outside(volume, body, close_by), 5)});
      add_modes(name, volume, body.inside, around_body(body, beside), around_body(body, close_by), rows);
    }
  std::vector<PaperSet> sets(paper_sets().begin(), paper_sets().end());
  sets.push_back({"smoke", "smoke.vdb", "", "", false});
  for (const PaperSet& set : sets) {
    if (folder.empty() || set.series || (report.quick && std::string(set.name) != "tooth")) continue;
    const auto source = load_paper_set(set, folder);
    if (!source || (source->type != SourceType::u8 && source->type != SourceType::f32)) continue;
    const PictureVolume volume(device.get(), *source);
    const std::vector<float> values = source->frame(0);
    const bccsplat_look look = volume.look();
    add_modes(set.name, volume, *std::max_element(values.begin(), values.end()),
              around_set(*source, look.empty, beside), around_set(*source, look.empty, close_by), rows);
  }
  report.table("the field beside an edge, of the value inside", fields);
  report.table("the background of pictures by the defaults, from the front, of 255", rows);
}

} // namespace bccsplat::bench
