// SPDX-License-Identifier: Apache-2.0
// The level is decided by the size of a pixel; the box is that of the vertices of what the planes of the view
// and the faces of the domain leave, found where three of these planes meet.
#include "scene/picture_needs.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "view/sheet_metric.h"
#include "volume/labels.h"

namespace bccsplat {
namespace {

// A level is good whose field is off by no more in the mean, 54 dB of the range, and nowhere by more than a
// twentieth, and whose distance is at most five pixels in a draft and three in a normal picture: such
// pictures are as near to the truth as their quality is, 35.5 and 39 dB (tests/bench/notes/moments.md).
constexpr double good_error = 0.002, good_largest = 0.05;
constexpr double draft_distance = 1 / 5.0, normal_distance = 1 / 3.0;
// Rounding of a pixel's size.
constexpr double nearly = 1 - 1e-9;
// Pixels beyond the picture's edge, and source samples beyond what they see, whose field shading asks for.
constexpr double pixel_margin = 2, sample_margin = 3;

// The half-spaces of points whose pixels lie in the picture and that are in front of the eye, and what clips
// them.
std::vector<HalfSpace> view_planes(const SheetView& v) {
  std::vector<HalfSpace> planes;
  const auto through_eye = [&](const Vec3& normal, double offset) {
    planes.push_back({normal, offset - dot(normal, v.eye)});
  };
  const Vec3 depth = (1 / v.step) * v.normal; // sheets from the eye
  // Column of p: gx.(p - eye) less the drift with depth; in perspective all of that over the depth.
  const auto between = [&](const Vec3& g, double low, double high) {
    const Vec3 straight = g - dot(g, v.ez) * depth;
    through_eye(v.perspective ? straight - low * depth : straight, v.perspective ? 0 : -low);
    through_eye(v.perspective ? high * depth - straight : -1 * straight, v.perspective ? 0 : high);
  };
  between(v.gx, -pixel_margin, v.width - 1 + pixel_margin);
  between(v.gy, -pixel_margin, v.height - 1 + pixel_margin);
  if (v.perspective) through_eye(depth, 0);
  if (v.in_front) through_eye(depth, v.depth);
  planes.insert(planes.end(), v.clip.begin(), v.clip.end());
  return planes;
}

double distance_to(const HalfSpace& plane, const Vec3& p) {
  return (dot(plane.normal, p) + plane.offset) / length(plane.normal);
}

// The point where three planes meet; NaN where they do not meet in one.
Vec3 meeting_point(const HalfSpace& a, const HalfSpace& b, const HalfSpace& c) {
  const Vec3 bc = cross(b.normal, c.normal);
  const double volume = dot(a.normal, bc);
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  if (volume == 0) return {nan, nan, nan};
  const Vec3 sum =
      a.offset * bc + (b.offset * cross(c.normal, a.normal) + c.offset * cross(a.normal, b.normal));
  return (-1 / volume) * sum;
}

} // namespace

double distances_per_pixel(const Slice& slice, const Lattice4& lattice, const Sight& sight, int width,
                           int height) {
  SheetView view = make_view(slice, sight, width, height, 1);
  const Vec3 unit = lattice.lattice_unit();
  for (Vec3* edge : {&view.ex, &view.ey}) {
    *edge = slice.lattice_to_slice.vector(*edge);
    for (size_t a = 0; a < 3; ++a) (*edge)[a] /= unit[a];
  }
  return view.scale(0) * SheetMetric(view).extremes()[0];
}

int enough_level(std::span<const LevelOption> levels, const RenderOptions& options) {
  if (options.reference || options.mode == RenderMode::maximum ||
      (options.disable_skips & skip_fine_detail) || !quality_settings(options.quality).coarse_levels)
    return 0;
  const double distance = options.quality == Quality::draft ? draft_distance : normal_distance;
  int enough = 0;
  for (size_t l = 1; l < levels.size(); ++l) {
    const LevelOption& level = levels[l];
    const bool good = level.error && level.error->rmse <= good_error && level.error->largest <= good_largest;
    if (level.per_pixel >= (good ? distance : 1) * nearly) enough = static_cast<int>(l);
  }
  return enough;
}

std::optional<IndexBox> seen_box(const Slice& slice, const Sight& sight, int width, int height) {
  const SheetView view = make_view(slice, sight, width, height, 1);
  const DrawnBox drawn = drawn_box(slice);
  std::vector<HalfSpace> planes = view_planes(view);
  for (size_t a = 0; a < 3; ++a) {
    Vec3 axis{};
    axis[a] = 1;
    planes.push_back({axis, -drawn.begin[a]});
    planes.push_back({-1 * axis, drawn.end[a]});
  }
  const double tolerance = 1e-9 * (1 + length(drawn.end - drawn.begin) + length(view.eye));
  constexpr double none = std::numeric_limits<double>::infinity();
  Vec3 low{none, none, none}, high{-none, -none, -none};
  const size_t n = planes.size();
  for (size_t i = 0; i < n; ++i)
    for (size_t j = i + 1; j < n; ++j)
      for (size_t k = j + 1; k < n; ++k) {
        const Vec3 p = meeting_point(planes[i], planes[j], planes[k]);
        // The comparison also refuses NaN.
        if (!std::all_of(planes.begin(), planes.end(),
                         [&](const HalfSpace& plane) { return distance_to(plane, p) >= -tolerance; }))
          continue;
        const Vec3 sample = slice.lattice_to_slice.point(p);
        for (size_t a = 0; a < 3; ++a)
          low[a] = std::min(low[a], sample[a]), high[a] = std::max(high[a], sample[a]);
      }
  if (low[0] > high[0]) return std::nullopt;
  IndexBox box{low, high};
  for (size_t a = 0; a < 3; ++a) box.begin[a] -= sample_margin, box.end[a] += sample_margin;
  return box;
}

PictureNeeds picture_needs(const OpenVolume& volume, uint32_t channel, const Slice& slice, const Sight& sight,
                           int width, int height, const RenderOptions& options) {
  std::vector<LevelOption> levels;
  for (uint32_t l = 0; l <= volume.info().levels.size(); ++l)
    levels.push_back({distances_per_pixel(slice, volume.lattice(l), sight, width, height),
                      level_error(volume.info(), channel, l)});
  PictureNeeds needs;
  needs.level = is_labels(volume, channel) ? 0 : enough_level(levels, options); // labels have no means
  needs.distances_per_pixel = levels.front().per_pixel;
  const Lattice4& lattice = volume.lattice(0);
  for (size_t a = 0; a < 3; ++a) needs.box.end[a] = lattice.domain_end(a);
  if (const auto seen = seen_box(slice, sight, width, height))
    needs.box = clip_to_samples(*seen, lattice), needs.seen = true;
  return needs;
}

} // namespace bccsplat
