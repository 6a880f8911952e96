// SPDX-License-Identifier: Apache-2.0
// Rays go on slab by slab in squares of pixels, so that samples lie side by side: all samples that a slab
// asks for are summed at once. Between samples beside each other a ray looks for a change of side, and for a
// turn that may pass the value twice; both ends of what it looks at lie on whole sheets, so that cells which
// are passed over change nothing that it finds.
#include "tests/bench/rays/ray_picture.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>
#include <vector>

#include "splat/shade/surface.h"

namespace bccsplat::bench {
namespace {

constexpr int square = 16; // pixels a side of those that go on together
constexpr double outside_tolerance = 1e-5;

struct Station {
  int k = -(1 << 20);          // none
  double value = 0, slope = 0; // per sheet
};

// The whole number below a sheet number.
int below(double k) {
  constexpr int lift = 1 << 20;
  return static_cast<int>(k + lift) - lift;
}

// The samples of one ray in a slab: [first, end) of all.
struct Part {
  uint32_t ray, next, end;
};

struct Square {
  std::array<BlockWay::Ray, square * square> ray;
  std::array<Station, square * square> last;
  std::array<uint32_t, square * square> layers;
  std::array<Vec3, square * square> origin; // at sheet 0
  uint32_t count = 0;                       // of the samples of a slab
  std::vector<int> samples;                 // sheets
  std::vector<Vec4> places;
  std::vector<float> values;
  std::vector<std::array<float, 4>> gradients;
  std::vector<Part> parts;
  std::vector<Crossing> crossings, grazes;
};

class Drawing {
 public:
  Drawing(const Scene& scene, double iso_value, const SurfaceField& field, const SheetView& view,
          const BlockWay& way, RayCounts& counts, Image& image)
      : scene_(scene), target_(iso_value - static_cast<double>(scene.slice->base)), field_(field),
        view_(view), way_(way), counts_(counts), image_(image), color_(scene.function.color(iso_value)),
        to_viewer_(bccsplat::to_viewer(view, 0, 0)), q_(std::make_unique<Square>()) {}

  void draw() {
    const size_t room = square * square * way_.most_sheets();
    q_->samples.resize(room), q_->places.resize(room), q_->values.resize(room), q_->gradients.resize(room);
    for (int y = 0; y < image_.height; y += square)
      for (int x = 0; x < image_.width; x += square) draw_square(x, y);
  }

 private:
  void draw_square(int x, int y) {
    Square& q = *q_;
    x_ = x, y_ = y;
    std::array<uint32_t, square * square> open;
    size_t count = 0;
    for (int j = 0; j < std::min(square, image_.height - y); ++j) {
      std::fill_n(image_.rgba.at(x, y + j), 4 * std::min(square, image_.width - x), 0.0f);
      for (int i = 0; i < std::min(square, image_.width - x); ++i) {
        const auto n = static_cast<uint32_t>(j * square + i);
        if (!way_.any(x + i, y + j)) continue;
        if (!way_.begin(*scene_.slice, view_, x + i, y + j, q.ray[n])) continue;
        q.last[n] = {};
        q.origin[n] = view_.sample(x + i, y + j, 0);
        q.layers[n] = way_.advance(q.ray[n]);
        if (q.layers[n] != 0) open[count++] = n;
      }
    }
    while (count > 0) {
      int slab = q.ray[open[0]].slab;
      for (size_t n = 1; n < count; ++n) slab = std::min(slab, q.ray[open[n]].slab);
      q.count = 0, q.parts.clear();
      for (size_t n = 0; n < count; ++n)
        if (q.ray[open[n]].slab == slab) ask(open[n]);
      search();
      ++counts_.searches;
      size_t left = 0;
      for (size_t n = 0; n < count; ++n) {
        const uint32_t r = open[n];
        BlockWay::Ray& ray = q.ray[r];
        if (ray.slab == slab) { // hits have ended theirs
          ++ray.slab;
          q.layers[r] = way_.advance(ray);
          if (q.layers[r] == 0) continue;
        }
        open[left++] = r;
      }
      count = left;
    }
  }

  // Notes the sheets that the ray's layers lie between and that it has not looked at yet.
  void ask(uint32_t r) {
    Square& q = *q_;
    const uint32_t first = q.count;
    const BlockWay::Ray& ray = q.ray[r];
    const Vec3 &at = q.origin[r], &ez = view_.ez;
    int last = q.last[r].k;
    way_.each_layer(ray, q.layers[r], [&](double from, double to) {
      from = std::max(from, ray.enter), to = std::min(to, ray.leave);
      if (to < from) return;
      const int low = below(from), high = -below(-to);
      for (int k = std::max(low, last + 1); k <= high; ++k) {
        q.samples[q.count] = k;
        q.places[q.count++] = {at[0] + k * ez[0], at[1] + k * ez[1], at[2] + k * ez[2], 0};
        last = k;
      }
    });
    if (q.count > first) q.parts.push_back({r, first, q.count});
  }

  void search() {
    Square& q = *q_;
    if (q.count == 0) return;
    counts_.samples += q.count;
    sum_footprints(field_.footprints, std::span(q.places).first(q.count), q.values.data(),
                   q.gradients.data());
    std::vector<uint32_t> open(q.parts.size());
    for (uint32_t p = 0; p < open.size(); ++p) open[p] = p;
    while (!open.empty()) {
      q.crossings.clear(), q.grazes.clear();
      for (const uint32_t p : open) scan(p);
      open.clear();
      settle(open);
    }
  }

  // Goes on along the samples of a part until something is found.
  void scan(uint32_t p) {
    Square& q = *q_;
    Part& part = q.parts[p];
    Station& last = q.last[part.ray];
    const Vec3& ez = view_.ez;
    while (part.next < part.end) {
      const auto& g = q.gradients[part.next];
      const double slope = static_cast<double>(g[0]) * ez[0] + static_cast<double>(g[1]) * ez[1] +
                           static_cast<double>(g[2]) * ez[2];
      const Station here{q.samples[part.next], static_cast<double>(q.values[part.next]), slope};
      ++part.next;
      const Station before = last;
      last = here;
      if (before.k != here.k - 1) continue;
      const double i = x_ + static_cast<int>(part.ray) % square, j = y_ + static_cast<int>(part.ray) / square;
      const Crossing c{i, j, 1.0 * before.k, 1.0 * here.k, before.value, here.value, before.slope, slope, p};
      const double d0 = before.value - target_, d1 = here.value - target_;
      if ((d0 < 0) != (d1 < 0)) {
        q.crossings.push_back(c);
        return;
      }
      // It comes closer, goes away, and the tangents meet beyond the target.
      const double side = d0 < 0 ? 1 : -1, s0 = side * before.slope, s1 = side * slope;
      if (!(s0 > 0 && s1 < 0)) continue;
      const double meet = (side * (d1 - d0) - s1) / (s0 - s1);
      if (!(side * d0 + s0 * meet > 0)) continue;
      q.grazes.push_back(c);
      return;
    }
  }

  // Refines what was found; rays for which that was nothing go on.
  void settle(std::vector<uint32_t>& open) {
    Square& q = *q_;
    if (!q.grazes.empty()) {
      counts_.grazes += q.grazes.size();
      const auto found = find_grazes(field_, view_, target_, q.grazes);
      std::vector<bool> passed(q.parts.size(), false);
      for (const Crossing& c : found) passed[c.number] = true;
      for (const Crossing& c : q.grazes)
        if (!passed[c.number]) open.push_back(c.number);
      q.crossings.insert(q.crossings.end(), found.begin(), found.end());
    }
    if (q.crossings.empty()) return;
    const auto points = refine_crossings(field_, view_, target_, q.crossings, root_tolerance);
    for (size_t n = 0; n < points.size(); ++n) {
      const Crossing& c = q.crossings[n];
      BlockWay::Ray& ray = q.ray[q.parts[c.number].ray];
      if (points[n].k < ray.enter - outside_tolerance || points[n].k > ray.leave + outside_tolerance) {
        open.push_back(c.number);
        continue;
      }
      ++counts_.hits;
      const Shading lit = shade(scene_.lights, points[n].gradient, to_viewer_, target_);
      float* const rgba = image_.rgba.at(static_cast<int>(c.i), static_cast<int>(c.j));
      for (size_t a = 0; a < 3; ++a)
        rgba[a] = static_cast<float>(color_[a] * lit.scale[a] + lit.highlight[a]);
      rgba[3] = 1;
      ray.end = 0;
    }
  }

  const Scene& scene_;
  double target_;
  const SurfaceField& field_;
  const SheetView& view_;
  const BlockWay& way_;
  RayCounts& counts_;
  Image& image_;
  Vec3 color_;
  Vec3 to_viewer_;
  std::unique_ptr<Square> q_;
  int x_ = 0, y_ = 0;
};

} // namespace

RayPicture::RayPicture(const Scene& scene, const CellRanges& ranges, double iso_value, bool everywhere)
    : scene_(scene), ranges_(ranges), iso_value_(iso_value), everywhere_(everywhere),
      sums_(lattice_sums(*scene.slice)) {}

void RayPicture::draw(double step, bool keep_bits, Image& image) {
  counts_ = {};
  const SheetView view =
      make_view(*scene_.slice, resolve_camera(scene_.camera), image.width, image.height, step);
  if (!keep_bits || bits_.bits.empty()) {
    size_t along = 0;
    for (size_t a = 1; a < 3; ++a)
      if (std::fabs(view.ez[a]) > std::fabs(view.ez[along])) along = a;
    bits_ =
        make_block_bits(ranges_, along, iso_value_ - static_cast<double>(scene_.slice->base), everywhere_);
  }
  const SurfaceField field(*scene_.slice, sums_);
  Drawing(scene_, iso_value_, field, view, BlockWay(bits_, *scene_.slice, view), counts_, image).draw();
}

} // namespace bccsplat::bench
