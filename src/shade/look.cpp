// SPDX-License-Identifier: Apache-2.0
// Opacities come from optical depths: that of a ray through the middle of the object, divided by the voxels
// it crosses there, so that an object is as opaque in a large volume as in a small one.
#include "shade/look.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "base/error.h"
#include "shade/kind_look.h"

namespace bccsplat {
namespace {

// Optical depths across the object: of solids a surface is seen, of fog the inside, too.
constexpr double solid_depth = 10, fog_depth = 3, tissue_depth = 5, dense_depth = 8, box_depth = 3;
// Per voxel: thin parts of a large solid are to be seen, and labels through the shells that lie between two.
constexpr double least_solid = 0.06, label_depth = 0.5, surface_depth = 2;
constexpr double most_opacity = 0.95;
constexpr size_t most_windows = 8; // of four points each
// Colours: where the mean is at least, of the way from the first to the last, and the largest bend for that;
// of two signs, where the colours halfway are at least, of the way to the farthest value.
constexpr double lowest_mean = 0.42, most_bend = 2.5, least_half = 0.1;

constexpr Vec3 ivory{0.68, 0.60, 0.47};

// Shares of the distance to the farthest value: the parts of a side are no nearer to its edge.
constexpr double least_mean = 0.05, least_object = 0.1, least_boundary = 0.02;
// Ranges of values are taken for no narrower than this part of the values themselves.
constexpr double least_range = 1e-6, least_value = 1e-30;
// Shares of a solid's optical depth: halfway to its boundary, and at it.
constexpr double depth_before = 0.05, depth_at_boundary = 0.4;
// What is farther than the object is denser, by so many times its share of the object's distance; at most.
constexpr double denser = 4, densest = 3;
constexpr double level_set_rise = 0.02; // of the way to the farthest distance, to the surface's depth
constexpr double of_maximum = 0.25;     // of the mean's distance: what is farther is opaque in a maximum
// Windows of labels, in distances to the nearest other label or to the background: half the width of the one
// around all labels, of narrow ones around each, and of the slopes beside them.
constexpr double half_window = 0.5, half_narrow_window = 0.2, half_slope = 0.05;

// Distance from the end of the empty values, and extinction of a voxel.
struct ProfilePoint {
  double distance, depth;
};
using Profile = std::vector<ProfilePoint>;

// Distances from the end of the empty values on one side.
struct Side {
  double edge, sign, mean, boundary, object, far;
  double crossing; // voxels along a ray
};

Side side_of(const ValueSurvey& s, bool above) {
  Side e;
  e.sign = above ? 1 : -1;
  e.edge = above ? s.empty.high : s.empty.low;
  if (!std::isfinite(e.edge)) e.edge = above ? s.colors.low : s.colors.high;
  if (s.empty.low > s.empty.high) e.edge = s.background;
  const double tiny =
      least_range * std::max({std::fabs(s.colors.high), std::fabs(s.colors.low), least_value});
  e.far = std::max(e.sign * ((above ? s.colors.high : s.colors.low) - e.edge), tiny);
  const bool both = s.above && s.below;
  const SideOfValues& values = above ? s.upper : s.lower;
  const double mean = both && values.share > 0 ? values.mean : s.mean;
  // The rarer side is the smaller one, and is to be seen as well.
  e.crossing = both ? std::max(2.0, s.crossing * std::cbrt(std::min(1.0, 2 * values.share))) : s.crossing;
  e.mean = std::clamp(mean - std::fabs(e.edge - s.background), least_mean * e.far, e.far);
  e.object = std::clamp(e.sign * (s.object - e.edge), least_object * e.far, e.far);
  e.boundary = std::clamp(e.sign * (s.boundary - e.edge), least_boundary * e.far, e.object);
  return e;
}

Profile ramp(const Side& e, double depth) {
  return {{0, 0}, {e.mean, depth}, {e.far, depth * e.far / e.mean}};
}

// Little up to the boundary, where partial volumes and ringing are, and then a surface; what is denser than
// the object is seen in it.
Profile surface(const Side& e, double depth) {
  return {{0, 0},
          {0.5 * e.boundary, depth_before * depth},
          {e.boundary, depth_at_boundary * depth},
          {e.object, depth},
          {e.far, depth * std::min(densest, 1 + denser * (e.far - e.object) / e.object)}};
}

Profile rising(const Side& e, double depth) {
  Profile p;
  for (const double d :
       {0.0, 0.25 * e.mean, 0.5 * e.mean, 0.75 * e.mean, e.mean, 0.5 * (e.mean + e.far), e.far})
    p.push_back({d, depth * (d / e.mean) * (d / e.mean)});
  return p;
}

Profile profile_of(const ValueSurvey& s, const Side& e) {
  switch (s.kind) {
  case ValueKind::solid:
    return surface(e, std::max(solid_depth / e.crossing, least_solid));
  case ValueKind::both_signs:
    return ramp(e, kind_look(s.data).signed_depth / e.crossing);
  case ValueKind::constant:
    return {{0, 0}, {0.5 * e.far, std::max(solid_depth / e.crossing, least_solid)}};
  case ValueKind::level_set:
    return {{0, 0}, {level_set_rise * e.far, surface_depth}};
  case ValueKind::dense: // noise around an object is little of it
    return rising(e, box_depth / e.crossing);
  case ValueKind::empty:
  case ValueKind::labels:
  case ValueKind::fog:
    break;
  }
  return ramp(e, kind_look(s.data).fog_depth / e.crossing);
}

double opacity_of(double depth) { return std::min(-std::expm1(-depth), most_opacity); }

// Points rise; of those that would not, the later gives way.
void add_opacities(TransferFunction& f, const Side& e, const Profile& profile, bool opaque) {
  std::vector<OpacityPoint> points;
  for (const ProfilePoint& p : profile) {
    const double value = e.edge + e.sign * p.distance;
    if (!points.empty() && !(e.sign * (value - points.back().value) > 0)) continue;
    points.push_back({value, opaque && p.depth > 0 ? 1.0 : opacity_of(p.depth)});
  }
  if (e.sign < 0) std::reverse(points.begin(), points.end());
  f.opacities.insert(f.opacities.end(), points.begin(), points.end());
}

// bend: the power of the way that a colour has from low to high.
void add_colors(TransferFunction& f, double low, double high, double bend, const std::vector<Vec3>& stops) {
  if (!(high > low)) high = low + std::max(least_range, least_range * std::fabs(low));
  for (size_t i = 0; i < stops.size(); ++i) {
    const double way = static_cast<double>(i) / static_cast<double>(stops.size() - 1);
    f.colors.push_back({low + (high - low) * std::pow(way, bend), stops[i]});
  }
}

// The same of two signs: colours halfway from grey are at the mean.
void add_signed_colors(TransferFunction& f, const ValueSurvey& s, const std::vector<Vec3>& stops) {
  const double far = std::max(s.colors.high, least_value);
  const double half = std::clamp(s.mean, least_half * far, far / 2);
  const std::array<double, 5> values{-far, -half, 0, half, far};
  for (size_t i = 0; i < stops.size(); ++i) f.colors.push_back({values[i], stops[i]});
}

// Where a few values are far higher than all others, these would be of one colour, and dark: the mean is
// not far below the middle of the colours.
double bend_of_colors(const ValueSurvey& s) {
  if (s.below || !s.above || s.kind == ValueKind::constant) return 1;
  const double way = (s.background + s.mean - s.colors.low) / (s.colors.high - s.colors.low);
  if (!(way > 0 && way < lowest_mean)) return 1;
  return std::min(std::log(way) / std::log(lowest_mean), most_bend);
}

std::vector<Vec3> viridis_stops() {
  constexpr int stops = 32;
  std::vector<Vec3> colors;
  for (int i = 0; i <= stops; ++i) colors.push_back(viridis(static_cast<double>(i) / stops));
  return colors;
}

// Linear RGB. Fire rises through red to a white that is not pure; of two signs the one is blue, the other
// red.
const std::vector<Vec3> fire_stops{{0, 0, 0},        {0.17, 0.002, 0}, {0.69, 0.02, 0},
                                   {1, 0.21, 0.002}, {1, 0.69, 0.05},  {1, 1, 0.69}};
const std::vector<Vec3> grey_stops{{0.25, 0.25, 0.27}, {0.55, 0.55, 0.57}, {0.95, 0.95, 0.95}};
const std::vector<Vec3> mr_stops{{0.05, 0.035, 0.03}, {0.40, 0.30, 0.25}, {0.75, 0.68, 0.60}, {1, 1, 0.95}};
const std::vector<Vec3> sign_stops{
    {0.02, 0.05, 0.50}, {0.10, 0.30, 0.85}, {0.80, 0.80, 0.80}, {0.85, 0.22, 0.10}, {0.45, 0.01, 0.02}};
// Colours that differ in hue and lightness, again after twelve.
constexpr std::array<Vec3, 12> label_colors{{{0.80, 0.10, 0.08},
                                             {0.08, 0.30, 0.75},
                                             {0.12, 0.55, 0.15},
                                             {0.90, 0.55, 0.05},
                                             {0.40, 0.12, 0.60},
                                             {0.05, 0.60, 0.60},
                                             {0.85, 0.30, 0.50},
                                             {0.45, 0.60, 0.06},
                                             {0.30, 0.16, 0.06},
                                             {0.55, 0.65, 0.90},
                                             {0.90, 0.80, 0.35},
                                             {0.35, 0.35, 0.38}}};

// Returns how far a label is from what is nearest to it, another one or the background.
double label_gap(const ValueSurvey& s, size_t i) {
  const std::vector<double>& l = s.labels;
  const double gap = l[i] - (i == 0 ? s.background : l[i - 1]);
  if (i + 1 == l.size()) return gap;
  return std::min(gap, l[i + 1] - l[i]);
}

// The colours of labels: by their values, so that files of a kind look alike, or in their order where values
// would share colours.
std::vector<Vec3> colors_of_labels(const std::vector<double>& labels) {
  std::vector<size_t> numbers;
  for (const double l : labels)
    numbers.push_back(static_cast<size_t>(std::fmod(std::fabs(l), static_cast<double>(label_colors.size()))));
  const std::set<size_t> different(numbers.begin(), numbers.end());
  std::vector<Vec3> colors;
  for (size_t i = 0; i < labels.size(); ++i)
    colors.push_back(label_colors[different.size() < labels.size() ? i % label_colors.size() : numbers[i]]);
  return colors;
}

TransferFunction label_function(const ValueSurvey& s, bool opaque) {
  TransferFunction f;
  const std::vector<double>& l = s.labels;
  const std::vector<Vec3> colors = colors_of_labels(l);
  for (size_t i = 0; i < l.size(); ++i) {
    const double low = i == 0 ? s.boundary : 0.5 * (l[i - 1] + l[i]);
    const double high = i + 1 == l.size() ? l[i] + 0.5 : 0.5 * (l[i] + l[i + 1]);
    f.colors.push_back({low, colors[i]}), f.colors.push_back({high, colors[i]});
  }
  // Beside a label the field passes values of others: shells, which are thin where windows are narrow.
  const double opacity = opaque ? 1.0 : opacity_of(label_depth);
  const bool narrow = !opaque && l.size() > 1 && l.size() <= most_windows;
  for (size_t i = 0; i < (narrow ? l.size() : 1); ++i) {
    const double gap = label_gap(s, i);
    const double half = gap * (narrow ? half_narrow_window : half_window), slope = gap * half_slope;
    f.opacities.insert(f.opacities.end(), {{l[i] - half - slope, 0}, {l[i] - half + slope, opacity}});
    if (narrow && i + 1 < l.size())
      f.opacities.insert(f.opacities.end(), {{l[i] + half - slope, opacity}, {l[i] + half + slope, 0}});
  }
  return f;
}

constexpr std::array<Vec3, 5> ct_colors{
    {{0.60, 0.30, 0.20}, {0.70, 0.33, 0.22}, {0.62, 0.36, 0.22}, {0.80, 0.70, 0.55}, {0.95, 0.93, 0.88}}};
constexpr double skin_begins = 0.35;                // on the way from air to soft tissue
constexpr double hard_depth = 0.3, end_depth = 0.6; // of bone, per voxel

// Values of tissues by their distance from air in units of soft tissue's: bone begins well above it.
TransferFunction ct_function(const ValueSurvey& s, bool soft, bool opaque) {
  const double air = s.background, tissue = s.object > air ? s.object : air + std::max(s.mean, 1e-6);
  const double unit = tissue - air, bone = tissue + 0.15 * unit, hard = tissue + 0.4 * unit;
  const double end = std::max(s.colors.high, tissue + 0.8 * unit);
  const double skin = soft ? tissue_depth / s.crossing : 0;
  const auto opacity = [&](double depth) { return opaque && depth > 0 ? 1.0 : opacity_of(depth); };
  TransferFunction f;
  const std::array<double, 5> values{air, tissue, bone, hard, end};
  for (size_t n = 0; n < values.size(); ++n) f.colors.push_back({values[n], ct_colors[n]});
  f.opacities = {{air + skin_begins * unit, 0}, {air + 0.5 * unit, opacity(0.5 * skin)},
                 {tissue, opacity(skin)},       {bone, opacity(0.5 * skin)},
                 {hard, opacity(hard_depth)},   {end, opacity(end_depth)}};
  return f;
}

const std::vector<Vec3>& stops_of(Look look, const ValueSurvey& s) {
  static const std::vector<Vec3> viridis_colors = viridis_stops(), one{ivory, ivory};
  switch (look) {
  case Look::fire:
    return fire_stops;
  case Look::fog:
    return grey_stops;
  case Look::mr:
    return mr_stops;
  default:
    break;
  }
  if (s.kind == ValueKind::level_set) return one;
  if (s.kind == ValueKind::both_signs) return sign_stops;
  const std::vector<Vec3>& of_kind = kind_look(s.data).colors;
  return look != Look::automatic || of_kind.empty() ? viridis_colors : of_kind;
}

} // namespace

ValueSurvey survey_for(const ValueCounts& counts, Look look) {
  if (look == Look::both_signs) return survey_values(counts, ValueKind::both_signs);
  if (look == Look::automatic) return survey_values(counts);
  if (look != Look::labels) return survey_values(counts, ValueKind::dense);
  ValueSurvey s = survey_values(counts, ValueKind::labels);
  if (s.labels.empty())
    fail(Code::invalid_argument, "labels: the channel has other values than up to 32 whole numbers");
  return s;
}

TransferFunction look_function(const ValueSurvey& s, Look look, RenderMode mode) {
  const bool opaque = mode == RenderMode::maximum || mode == RenderMode::isosurface;
  TransferFunction f;
  if (!s.labels.empty()) {
    f = label_function(s, opaque);
  } else if (look == Look::ct_bone || look == Look::ct_soft) {
    f = ct_function(s, look == Look::ct_soft, opaque);
  } else {
    const std::vector<Vec3>& stops = stops_of(look, s);
    if (&stops == &sign_stops)
      add_signed_colors(f, s, stops);
    else
      add_colors(f, s.colors.low, s.colors.high, look == Look::automatic ? bend_of_colors(s) : 1, stops);
    const bool all = s.empty.low > s.empty.high || (s.kind == ValueKind::dense && opaque);
    if (all) f.opacities = {{s.colors.low, opaque ? 1.0 : opacity_of(dense_depth / s.crossing)}};
    for (const bool above : {false, true}) {
      if (all || !(above ? s.above : s.below)) continue;
      const Side e = side_of(s, above);
      Profile p = profile_of(s, e);
      if (look == Look::mr) p = ramp(e, tissue_depth / e.crossing);
      if (look == Look::fog || look == Look::fire) p = ramp(e, fog_depth / e.crossing);
      // In a maximum, what is not nearly air is opaque.
      if (opaque) p = {{0, 0}, {s.kind == ValueKind::solid ? e.boundary : of_maximum * e.mean, 1}};
      add_opacities(f, e, p, opaque);
    }
    if (f.opacities.empty()) f.opacities = {{s.background, 0}};
  }
  if (mode == RenderMode::isosurface && s.labels.empty() && look == Look::automatic)
    f.colors = {{s.surface, ivory}};
  return f;
}

} // namespace bccsplat
