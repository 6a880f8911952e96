// SPDX-License-Identifier: Apache-2.0
// Samples come as the file has them, each in the middle of its voxel. Between them values are linear, and
// where pixels are larger than voxels means; labels are those of the nearest sample, and so is what is
// missing.
#include "tool/view/planes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "tool/annotate/canvas.h"
#include "tool/annotate/color_bar.h"
#include "tool/annotate/font.h"
#include "tool/annotate/scale_bar.h"
#include "tool/view/even_places.h"
#include "tool/view/plane_sides.h"
#include "tool/view/time_slice.h"

namespace bcc4 {
namespace {

constexpr double margin_share = 0.02; // of a pane, around a plane
constexpr double em_share = 0.06, least_em = 12, most_em = 28;
constexpr double scale_share = 0.4; // of a pane, that the scale bar may have

// An axis of the samples, or the part of it that is looked at: where its voxels begin and end, in even
// positions.
struct Line {
  uint64_t first = 0, count = 0;
  double begin = 0, end = 0, length = 0; // length: in the world
  std::vector<double> places{};          // of the samples, where they are uneven
};

Line line_of(const Volume& volume, uint32_t axis, const std::optional<SampleBox>& region) {
  const bccsplat_volume_info v = volume_info(volume);
  Line line;
  line.first = region ? region->begin[axis] : 0;
  line.count = region ? region->dims[axis] : v.dims[axis];
  line.begin = -0.5, line.end = static_cast<double>(line.count) - 0.5;
  if (axis_info(volume, axis).count > 0 && line.count > 1) {
    for (uint64_t i = 0; i < line.count; ++i)
      line.places.push_back(even_position(volume, axis, static_cast<double>(line.first + i)));
    line.begin = line.places.front(), line.end = line.places.back();
  }
  const double* const column = v.affine + axis;
  line.length = (line.end - line.begin) * std::hypot(column[0], column[4], column[8]);
  return line;
}

// Returns the sample, or the place between two, at an even position.
double sample_at(const Line& line, double position) {
  double at = position;
  if (!line.places.empty()) {
    const auto above = std::upper_bound(line.places.begin() + 1, line.places.end() - 1, position);
    const double low = *(above - 1), high = *above;
    at = static_cast<double>(above - 1 - line.places.begin()) + (position - low) / (high - low);
  }
  return std::clamp(at, 0.0, static_cast<double>(line.count - 1));
}

// What a column or row of pixels is made of.
struct Taps {
  size_t nearest = 0, first = 0;
  std::vector<double> weights{};
};

std::vector<Taps> taps_of(const Line& line, uint32_t pixels, bool falls, bool nearest) {
  std::vector<Taps> out(pixels);
  const double step = (line.end - line.begin) / pixels;
  const auto place = [&](double pixel) {
    return sample_at(line, falls ? line.end - pixel * step : line.begin + pixel * step);
  };
  for (uint32_t i = 0; i < pixels; ++i) {
    Taps& t = out[i];
    const double at = place(i + 0.5), reach = std::max(1.0, std::fabs(place(i + 1) - place(i)));
    t.nearest = static_cast<size_t>(std::lround(at));
    if (nearest) {
      t.first = t.nearest, t.weights = {1};
      continue;
    }
    t.first = static_cast<size_t>(std::max(0.0, std::ceil(at - reach)));
    const auto last =
        static_cast<size_t>(std::min(static_cast<double>(line.count - 1), std::floor(at + reach)));
    for (size_t k = t.first; k <= last; ++k)
      t.weights.push_back(std::max(0.0, 1 - std::fabs(static_cast<double>(k) - at) / reach));
  }
  return out;
}

// Samples of a plane, the axis with the lower number fastest.
struct PlaneValues {
  std::vector<float> values;
  uint64_t width = 0;  // along that axis
  bool turned = false; // whether it is the one that runs up
  [[nodiscard]] float at(size_t right, size_t up) const {
    return turned ? values[right * width + up] : values[up * width + right];
  }
};

float mean_at(const PlaneValues& plane, const Taps& right, const Taps& up) {
  if (std::isnan(plane.at(right.nearest, up.nearest))) return std::numeric_limits<float>::quiet_NaN();
  double sum = 0, weight = 0;
  for (size_t v = 0; v < up.weights.size(); ++v)
    for (size_t u = 0; u < right.weights.size(); ++u) {
      const float value = plane.at(right.first + u, up.first + v);
      const double share = right.weights[u] * up.weights[v];
      if (!std::isnan(value)) sum += share * double{value}, weight += share;
    }
  return static_cast<float>(sum / weight);
}

bool are_grey(const std::vector<std::array<double, 4>>& colors) {
  return std::all_of(colors.begin(), colors.end(),
                     [](const auto& c) { return c[1] == c[2] && c[2] == c[3]; });
}

// Greys of a display rise as the values do.
Color grey_at(const std::vector<std::array<double, 4>>& colors, double value) {
  const double low = colors.front()[0], high = colors.back()[0];
  const double grey = srgb_to_linear(high > low ? std::clamp((value - low) / (high - low), 0.0, 1.0) : 1);
  return {grey, grey, grey};
}

// Returns the level of a map that is nearest to the ground: of heights and depths that nearest to 0, of
// pressures the highest.
uint64_t ground_level(const Volume& volume, uint32_t axis, const Line& line) {
  std::array<double, 6> ends{};
  ends[axis] = static_cast<double>(line.first),
  ends[3 + axis] = static_cast<double>(line.first + line.count - 1);
  check(bccsplat_volume_index_to_world(volume.get(), 2, ends.data(), ends.data()), "");
  const std::string unit = axis_units(volume)[axis];
  const bool pressure = unit.find("Pa") != std::string::npos || unit.find("bar") != std::string::npos;
  const bool first_is_lower = std::fabs(ends[2]) <= std::fabs(ends[5]);
  return line.first + (first_is_lower != pressure ? 0 : line.count - 1);
}

// Returns the unit of the world that both axes of a plane have.
std::string unit_of(const Volume& volume, const PlaneSides& s) {
  const std::array<std::string, 3> units = axis_units(volume);
  return units[s.right.axis] == units[s.up.axis] ? units[s.up.axis] : "";
}

void draw_sides(Canvas& canvas, const PlaneSides& s, const Point& from, const Point& to, double em) {
  const double x = (from[0] + to[0]) / 2, y = (from[1] + to[1]) / 2 + 0.36 * em, off = 0.35 * em;
  constexpr double room = 3; // em that both letters need inside; a thinner plane has them outside
  const bool thin = to[0] - from[0] < room * em, flat = to[1] - from[1] < room * em;
  canvas.text(s.right.low, {thin ? from[0] - off : from[0] + off, y}, em, thin ? Anchor::right : Anchor::left,
              {});
  canvas.text(s.right.high, {thin ? to[0] + off : to[0] - off, y}, em, thin ? Anchor::left : Anchor::right,
              {});
  canvas.text(s.up.high, {x, flat ? from[1] - off : from[1] + off + 0.73 * em}, em, Anchor::middle, {});
  canvas.text(s.up.low, {x, flat ? to[1] + off + 0.73 * em : to[1] - off}, em, Anchor::middle, {});
}

} // namespace

Planes::Planes(Volume volume, uint32_t channel, const PictureLayout& layout,
               std::vector<std::array<double, 4>> colors)
    : volume_(std::move(volume)), channel_(channel), layout_(layout), colors_(std::move(colors)) {
  require_font();
}

void Planes::draw(const Image& image, const Cut& where, const std::array<double, 3>& middle) {
  const std::array<PlaneSides, 3> sides = plane_sides(volume_);
  const std::vector<PlaneSides> shown =
      layout_.planes.size() == 1 ? std::vector{sides[2]} : std::vector(sides.begin(), sides.end());
  std::array<Line, 3> lines;
  for (uint32_t a = 0; a < 3; ++a) lines[a] = line_of(volume_, a, where.region);
  std::array<double, 3> index{};
  check(bccsplat_volume_world_to_index(volume_.get(), 1, middle.data(), index.data()), "");
  std::array<uint64_t, 3> at{};
  for (size_t a = 0; a < 3; ++a) {
    const auto first = static_cast<double>(lines[a].first), count = static_cast<double>(lines[a].count);
    at[a] = static_cast<uint64_t>(std::clamp(std::round(index[a]), first, first + count - 1));
  }
  if (shown.size() == 1) at[sides[2].across] = ground_level(volume_, sides[2].across, lines[sides[2].across]);
  // World lengths in a pixel, the same for all planes.
  double length = 0;
  for (size_t n = 0; n < shown.size(); ++n) {
    const PictureSize& pane = layout_.planes[n].size;
    length = std::max({length, lines[shown[n].right.axis].length / ((1 - 2 * margin_share) * pane.width),
                       lines[shown[n].up.axis].length / ((1 - 2 * margin_share) * pane.height)});
  }
  const bool labels = channel_info(volume_, channel_).labels != 0, grey = !labels && are_grey(colors_);
  auto pixels = sized<bccsplat_plane>();
  check(bccsplat_frame_get_channel(image.get(), BCCSPLAT_FRAME_RGBA, &pixels), "--layout");
  Canvas canvas(image);
  words_.clear();
  for (size_t n = 0; n < shown.size(); ++n) {
    const PlaneSides& s = shown[n];
    const Pane& pane = layout_.planes[n];
    const Line &right = lines[s.right.axis], &up = lines[s.up.axis];
    const auto side = [&](const Line& line) {
      return static_cast<uint32_t>(std::max(1.0, std::round(line.length / length)));
    };
    const uint32_t width = side(right), height = side(up);
    const uint32_t left = pane.x + (pane.size.width - width) / 2,
                   top = pane.y + (pane.size.height - height) / 2;
    SampleBox box;
    for (size_t a = 0; a < 3; ++a) box.begin[a] = lines[a].first, box.dims[a] = lines[a].count;
    box.begin[s.across] = at[s.across], box.dims[s.across] = 1;
    PlaneValues plane;
    plane.width = std::min(s.right.axis, s.up.axis) == s.right.axis ? right.count : up.count;
    plane.turned = s.right.axis > s.up.axis;
    sample_frame(volume_, where.index, channel_, box, [&](uint64_t, std::span<const float> some) {
      plane.values.insert(plane.values.end(), some.begin(), some.end());
    });
    const std::vector<Taps> columns = taps_of(right, width, s.right.falls, labels),
                            rows = taps_of(up, height, !s.up.falls, labels); // rows from the top
    for (uint32_t y = 0; y < height; ++y) {
      float* p = pixels.pixels + (top + y) * (pixels.row_bytes / sizeof(float)) + size_t{4} * left;
      for (uint32_t x = 0; x < width; ++x, p += 4) {
        const float value = mean_at(plane, columns[x], rows[y]);
        if (std::isnan(value)) continue;
        const Color c = grey ? grey_at(colors_, double{value}) : color_at(colors_, double{value});
        for (size_t i = 0; i < 3; ++i) p[i] = static_cast<float>(c[i]);
        p[3] = 1;
      }
    }
    const double em = std::clamp(em_share * std::min(pane.size.width, pane.size.height), least_em, most_em);
    const Point from{double(left), double(top)}, to{double(left + width), double(top + height)};
    draw_sides(canvas, s, from, to, em);
    const std::string unit = unit_of(volume_, s);
    if (n + 1 == shown.size() && !unit.empty())
      draw_scale_bar(canvas, length, unit, {pane.x + pane.size.width - em, pane.y + pane.size.height - em},
                     scale_share * pane.size.width, 0.8 * em, {});
    words_ += concat(words_.empty() ? "" : ", ", std::string(1, "xyz"[s.across]), " = ", at[s.across]);
    if (!s.right.low.empty() && !s.up.low.empty())
      words_ += concat(" (", s.right.low, " to ", s.right.high, ", ", s.up.low, " to ", s.up.high, ")");
  }
}

} // namespace bcc4
