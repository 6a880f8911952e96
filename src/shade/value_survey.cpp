// SPDX-License-Identifier: Apache-2.0
// Tells air and noise from what is to be seen. The background is the peak that most samples are in, where
// there is one; noise ends where the slope beside that peak does (the triangle method of Zack, Rogers and
// Latt 1977), and not before three standard deviations of its narrower side. Values that pile up beyond a
// valley are a solid object, whose boundary is midway between the two peaks, or behind a hump of haze that is
// there.
#include "shade/value_survey.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "shade/kind_look.h"
#include "shade/value_histogram.h"

namespace bccsplat {
namespace {

constexpr double unbounded = std::numeric_limits<double>::infinity();
constexpr size_t most_labels = 32;
// A peak is a background if no wider than this share of the range, and with so many of the samples in it.
constexpr double widest_background = 0.12, least_background = 0.15;
// The share of all samples at either end that do not tell how wide the range is; it counts no fewer bins.
constexpr double outliers = 0.002, narrowest_spread = 4;
constexpr double mode_over_width = 1.5; // half the width of what a background's samples are counted in
constexpr double slope_beyond = 8;      // bins farther than twice the noise, where the slope ends
constexpr double sigma_per_half_width = 1 / 1.1774; // of a normal distribution
constexpr double noise_sigmas = 3;
constexpr double smoothing = 1;    // bins that smoothing adds to the half-width of a peak
constexpr double single_bin = 1.5; // half-width that it gives to a peak of one bin
// The other side of a background is shown, too, where it has this share of the samples beyond the noise, and
// of the values: what is a little darker than noise is air as well.
constexpr double least_side = 0.1, least_side_range = 0.25;
// A pile is this much higher than the valley before it, and above its counting noise.
constexpr double pile_over_valley = 1.5, pile_sigmas = 4, least_pile = 0.1;
constexpr double least_of_all = 1e-4; // of all samples, in the bin of a pile
// Haze is a hump between background and pile: this much higher than what is least common before it and behind
// it, and no less than this share of the pile. It ends where values are as rare as behind it, nearly.
constexpr double hump_over_before = 1.1, hump_over_behind = 1.5, least_hump = 0.2, rare = 1.1;
constexpr double haze_of_all = 1e-3;  // of all samples, in its most common bin
constexpr double widest_labels = 255; // those of 8 bits
// A level set: how much farther one end may be from 0 than the other, and the share of the samples at an end.
constexpr double lopsided = 0.1, least_cut_off = 0.002;
// Values of both signs: the range of the lesser sign, how far the mode is from 0, what counts as 0, all as
// shares of the farthest; and the share of the samples that have either sign.
constexpr double least_sign = 0.2, farthest_mode = 0.1, near_zero = 0.02, least_of_sign = 0.02;
// Dense values above the median are shown, unless the range below it is this much longer.
constexpr double longer_side = 1.5;
// Where values have both signs those near 0 are not shown: so many standard deviations, told by the median,
// but at most this share of the farthest.
constexpr double sign_sigmas = 2.5, sigma_per_median = 1.4826, most_near_zero = 0.2;
// Noise may reach this share of the way from a background to the boundary of a solid.
constexpr double of_boundary = 0.4;
// Where the boundary of fog is, on the way from the noise to what divides its values best: nearer to that it
// is torn where values vary.
constexpr double of_threshold = 0.35;
// The share of the samples beyond the noise that is left out of the range of colours, at either end.
constexpr double color_tail = 0.002;
// The range of colours is no less than this share of the distance from the background: ripple is 0.0024 of
// it.
constexpr double narrowest_colors = 0.05;

// An object has no edge of its own where the values between noise and object are never rarer than this share
// of its commonest one, and no fewer than haze_of_all.
constexpr double no_edge = 0.3;

struct Background {
  bool found = false;
  double value = 0;
  Range noise; // no sample of what else there may be is taken for it where the two cannot be told apart
  Range slope; // all of the slope beside the peak
};

// Beside exact air there is one value only, be it ever so common.
bool is_mask(const ValueCounts& c) {
  return c.air_sites > 0 &&
         std::count_if(c.bins.begin(), c.bins.end(), [](uint64_t n) { return n > 0; }) == 1;
}

// A mode among the stored samples that air alone did not make: noise beside exact air counts, air does not
// hide it.
Background find_background(const Histogram& h, const ValueCounts& c) {
  Background b;
  const auto robust = [&](double share) {
    double left = share * h.total();
    for (size_t i = 0; i < h.all.size(); ++i)
      if ((left -= h.all[i]) <= 0) return static_cast<double>(i);
    return static_cast<double>(h.all.size());
  };
  const double spread = std::max(robust(1 - outliers) - robust(outliers), 1.0), total = h.total();
  const std::vector<double> all = smoothed(h.all, 1);
  const size_t highest = std::max_element(all.begin(), all.end()) - all.begin();
  const size_t peak = is_mask(c) ? h.bin(c.air) : highest;
  const double left = half_width(all, peak, -1), right = half_width(all, peak, 1);
  const double full = std::min(left, 2 * right) + std::min(right, 2 * left);
  const double reach = mode_over_width * std::max(full, 1.0) * h.width(),
               at = h.value(static_cast<double>(peak));
  if (full > std::max(widest_background * spread, narrowest_spread) ||
      h.mass(at - reach, at + reach) < least_background * total)
    return b;
  b.found = true;
  b.value = c.air_sites > 0 && h.bin(c.air) + 1 >= peak && h.bin(c.air) <= peak + 1 ? c.air : at;
  // The slope that noise leaves among the stored samples, by their own peak near the background.
  const std::vector<double> stored = smoothed(h.stored, 1);
  const auto from = static_cast<size_t>(std::max(0.0, static_cast<double>(peak) - 2)),
             to = std::min(h.all.size(), peak + 3);
  const size_t own = std::max_element(stored.begin() + from, stored.begin() + to) - stored.begin();
  const double sigma = std::max(std::min(left, right) - smoothing, 0.5) * sigma_per_half_width;
  const double away = noise_sigmas * sigma;
  const double knee_above = triangle_knee(stored, own, 1), knee_below = triangle_knee(stored, own, -1);
  const auto middle = static_cast<double>(peak);
  const auto above = [&](double most) {
    return h.value(std::max(middle + away, std::min(knee_above, most)) + 0.5);
  };
  const auto below = [&](double most) {
    return h.value(std::min(middle - away, std::max(knee_below, most)) - 0.5);
  };
  b.noise = {below(middle - 2 * away - 1), above(middle + 2 * away + 1)};
  b.slope = {below(middle - 4 * away - slope_beyond), above(middle + 4 * away + slope_beyond)};
  return b;
}

// A pile of samples beyond `from`, and behind a valley: the first top of those that are not far lower than
// the highest, which are ringing and the like.
struct Pile {
  bool found = false;
  double top = 0;
};

Pile find_pile(const Histogram& h, double from, int step) {
  constexpr int reach = 3;
  const std::vector<double> s = smoothed(h.all, reach);
  const std::ptrdiff_t n = s.size();
  std::vector<size_t> tops;
  double least = unbounded;
  bool rising = false;
  for (std::ptrdiff_t i = h.bin(from); i >= 0 && i < n; i += step) {
    const size_t at = i;
    const double here = s[at], noise = pile_sigmas * std::sqrt(std::max(least, 1.0) / (2 * reach + 1));
    least = std::min(least, here);
    if (rising && here > s[tops.back()]) {
      tops.back() = at;
    } else if (rising && here < s[tops.back()] / pile_over_valley) {
      rising = false, least = here;
    } else if (!rising && here > pile_over_valley * least && here > least + noise &&
               here > least_of_all * h.total()) {
      rising = true, tops.push_back(at);
    }
  }
  double highest = 0;
  for (const size_t t : tops) highest = std::max(highest, s[t]);
  for (const size_t t : tops)
    if (s[t] > least_pile * highest) return {true, h.value(static_cast<double>(t))};
  return {};
}

// Returns `boundary`, or where it is before a hump of haze or in it, the value behind the hump from which a
// surface has nothing but the pile inside. The noise of the background ends at `edge`.
double boundary_behind_haze(const Histogram& h, double edge, const Pile& pile, double boundary) {
  const std::vector<double> s = smoothed(h.all, 1);
  const std::ptrdiff_t first = h.bin(edge), middle = h.bin(boundary), top = h.bin(pile.top);
  const std::ptrdiff_t step = first < top ? 1 : -1;
  if ((middle - first) * step <= 0 || (top - middle) * step <= 1) return boundary;
  std::ptrdiff_t behind = middle;
  for (std::ptrdiff_t i = middle; i != top; i += step)
    if (s[i] < s[behind]) behind = i;
  std::ptrdiff_t before = first, least = first, hump = first;
  for (std::ptrdiff_t i = first; i != behind; i += step) {
    if (s[i] < s[least]) least = i;
    // The hump is what rises most, as a ratio, from what came before.
    if (s[i] * s[before] > s[hump] * s[least]) hump = i, before = least;
  }
  if (s[hump] < hump_over_before * s[before] || s[hump] < hump_over_behind * s[behind] ||
      s[hump] < least_hump * s[top] || s[hump] < haze_of_all * h.total())
    return boundary;
  // A hump that is over before the boundary does not matter.
  if ((middle - hump) * step > 0 && s[middle] * hump_over_behind < s[hump]) return boundary;
  std::ptrdiff_t end = hump;
  while (end != behind && s[end] > rare * s[behind]) end += step;
  return (end - middle) * step > 0 ? h.value(static_cast<double>(end)) : boundary;
}

// Returns the boundary, or where a surface there would be torn the commonest value of the object, which is a
// fifth of all at least. The noise of the background ends at `edge`. Fog has no commonest value: as far
// beyond it there is as much.
double surface_of(const Histogram& h, double edge, const Pile& pile, double boundary) {
  constexpr int reach = 3;
  const std::vector<double> s = smoothed(h.all, reach);
  const auto [first, last] = std::minmax({h.bin(edge), h.bin(pile.top)});
  const double least = *std::min_element(s.begin() + first, s.begin() + last + 1);
  constexpr double large = 0.2, falls = 0.47;
  const double end = pile.top > edge ? h.range.high : h.range.low;
  const bool peaked = s[h.bin(2 * pile.top - edge)] < falls * s[h.bin(pile.top)];
  const bool torn = peaked && h.mass(std::min(edge, end), std::max(edge, end)) > large * h.total() &&
                    least > no_edge * s[h.bin(pile.top)] && least > haze_of_all * h.total();
  return torn ? pile.top : boundary;
}

// The standard deviation that the narrower side of a pile has; 0 where bins are too wide to tell, and where
// the pile is not half as high before its boundary: so flat a pile is of values that vary, and ends where
// these do.
double pile_noise(const Histogram& h, double top, double boundary) {
  constexpr size_t around = 4; // the pile was found by a longer mean
  const std::vector<double> s = smoothed(h.all, 1);
  const size_t near = h.bin(top), from = near - std::min(near, around),
               to = std::min(near + around + 1, s.size());
  const size_t peak = std::max_element(s.begin() + from, s.begin() + to) - s.begin();
  const double left = half_width(s, peak, -1), right = half_width(s, peak, 1), half = std::min(left, right);
  if ((boundary < top ? left : right) * h.width() > std::fabs(top - boundary)) return 0;
  return std::max(half - single_bin, 0.0) * h.width() * sigma_per_half_width;
}

// The values that a file's labels may have: the whole numbers of each bin, or where it holds none, or more
// than colours can be told for, an end of all values or its middle.
bool list_labels(const ValueCounts& c, std::vector<double>& labels) {
  constexpr double near = 1e-6, most_of_bin = 16;
  const double step = (c.stored.high - c.stored.low) / static_cast<double>(c.bins.size());
  const auto add = [&](double label) {
    if (label != c.air && (labels.empty() || labels.back() < label)) labels.push_back(label);
  };
  for (size_t i = 0; i < c.bins.size(); ++i) {
    if (c.bins[i] == 0) continue;
    const double low = c.stored.low + static_cast<double>(i) * step;
    const double first = std::ceil(low - near), last = std::floor(low + step + near);
    if (first <= last && last - first < most_of_bin)
      for (double label = first; label <= last; ++label) add(label);
    else
      add(i == 0 ? c.stored.low : i + 1 == c.bins.size() ? c.stored.high : low + 0.5 * step);
  }
  return !labels.empty();
}

bool find_labels(const ValueCounts& c, std::vector<double>& labels) {
  if (!c.integers || !c.exact || c.source.high - c.source.low > widest_labels ||
      c.stored.high - c.stored.low > widest_labels)
    return false;
  const double step = (c.stored.high - c.stored.low) / static_cast<double>(c.bins.size());
  for (size_t i = 0; i < c.bins.size(); ++i) {
    if (c.bins[i] == 0) continue;
    const double low = c.stored.low + static_cast<double>(i) * step;
    const double label = c.rounding > 0 ? std::round(low + 0.5 * step) : std::floor(low + step + 1e-6);
    if (label != c.air && label <= c.source.high && (labels.empty() || labels.back() != label))
      labels.push_back(label);
    if (labels.size() > most_labels) return false;
  }
  return !labels.empty();
}

// Distances are floats, cut off at the same distance inside and outside, and most samples lie there.
bool is_level_set(const Histogram& h, const ValueCounts& c) {
  const Range& r = h.range;
  if (c.integers || !(r.low < 0 && r.high > 0) || std::fabs(r.low + r.high) > lopsided * r.high) return false;
  const double edge = 0.04 * (r.high - r.low), total = h.total();
  const double inside = h.mass(-unbounded, r.low + edge), outside = h.mass(r.high - edge, unbounded);
  return inside + outside > 0.5 * total && inside > least_cut_off * total && outside > least_cut_off * total;
}

// Most are near 0, and what is not is on both sides, less of it the farther.
bool has_both_signs(const Histogram& h) {
  const Range& r = h.range;
  if (!(r.low < 0 && r.high > 0)) return false;
  const double reach = std::max(-r.low, r.high);
  if (std::min(-r.low, r.high) < least_sign * reach) return false;
  const std::vector<double> s = smoothed(h.all, 3);
  const auto mode = static_cast<double>(std::max_element(s.begin(), s.end()) - s.begin());
  if (std::fabs(h.value(mode)) > farthest_mode * reach) return false;
  const double total = h.total(), small = near_zero * reach;
  if (h.mass(-unbounded, -small) < least_of_sign * total || h.mass(small, unbounded) < least_of_sign * total)
    return false;
  // The last quarter of either side holds less than the second.
  return h.mass(-unbounded, 3 * r.low / 4) <= h.mass(r.low / 2, r.low / 4) &&
         h.mass(3 * r.high / 4, unbounded) <= h.mass(r.high / 4, r.high / 2);
}

// Returns a range, on the side of the background widened where it is narrow.
Range wide_enough(Range colors, double background) {
  const double low = std::fabs(colors.low - background), high = std::fabs(colors.high - background);
  const double least = narrowest_colors * std::max(low, high);
  if (colors.high - colors.low >= least) return colors;
  if (low < high) return {colors.high - least, colors.high};
  return {colors.low, colors.low + least};
}

// Completes a survey by what the samples outside its empty values are.
void describe_rest(const Histogram& h, const ValueCounts& c, ValueSurvey& s) {
  double count = 0, distance = 0;
  s.lower = s.upper = {};
  std::vector<double> rest(h.all.size(), 0.0);
  for (size_t i = 0; i < h.all.size(); ++i) {
    const double v = h.value(static_cast<double>(i));
    const bool shown = (s.above && v > s.empty.high) || (s.below && v < s.empty.low);
    if (!shown && s.empty.low <= s.empty.high) continue;
    rest[i] = h.all[i], count += h.all[i];
    distance += h.all[i] * std::fabs(v - s.background);
    SideOfValues& side = v < s.background ? s.lower : s.upper;
    side.share += h.all[i], side.mean += h.all[i] * std::fabs(v - s.background);
  }
  if (count == 0) return;
  s.mean = distance / count;
  for (SideOfValues* side : {&s.lower, &s.upper}) {
    if (side->share > 0) side->mean /= side->share;
    side->share /= count;
  }
  s.crossing = std::max(2.0, std::cbrt(count / h.total() * c.voxels));
  const auto tail = [&](bool from_above) {
    double left = (from_above ? kind_look(c.data).rim : color_tail) * count;
    for (size_t n = 0; n < rest.size(); ++n) {
      const size_t i = from_above ? rest.size() - 1 - n : n;
      if ((left -= rest[i]) < 0) return h.value(static_cast<double>(i) + (from_above ? 0.5 : -0.5));
    }
    return from_above ? h.range.high : h.range.low;
  };
  s.colors = wide_enough({tail(false), tail(true)}, s.background);
}

ValueSurvey survey_signs(const Histogram& h, const ValueCounts& c) {
  ValueSurvey s;
  s.kind = ValueKind::both_signs, s.below = s.above = true;
  const double reach = std::max(-h.range.low, h.range.high);
  const double limit = std::min(most_near_zero * reach, sign_sigmas * sigma_per_median * median_size(h));
  s.empty = {-limit, limit};
  describe_rest(h, c, s);
  const double far = std::max(-s.colors.low, s.colors.high);
  s.colors = {-far, far};
  s.boundary = 0.5 * (limit + s.mean);
  return s;
}

ValueSurvey survey_dense(const Histogram& h, const ValueCounts& c) {
  ValueSurvey s;
  s.kind = ValueKind::dense;
  s.empty = {1, 0};
  s.above = true;
  s.background = h.range.low;
  describe_rest(h, c, s);
  s.boundary = otsu_threshold(h.all, h.range, h.range.low);
  if (c.incomplete) return s;
  // Where nothing is missing the box itself would be all that is seen: the commoner half is not shown.
  double left = 0.5 * h.total();
  size_t middle = 0;
  while (middle + 1 < h.all.size() && (left -= h.all[middle]) > 0) ++middle;
  const double median = h.value(static_cast<double>(middle));
  s.background = median;
  s.below = median - s.colors.low > longer_side * (s.colors.high - median);
  s.above = !s.below;
  s.empty = s.above ? Range{-unbounded, median} : Range{median, unbounded};
  const Range colors = s.colors;
  describe_rest(h, c, s);
  s.colors = colors;
  s.boundary = 0.5 * (median + (s.above ? colors.high : colors.low));
  return s;
}

ValueSurvey survey_object(const Histogram& h, const ValueCounts& c, const Background& b) {
  ValueSurvey s;
  s.background = b.value;
  const double over = h.mass(b.noise.high, unbounded), under = h.mass(-unbounded, b.noise.low);
  const double far_over = h.range.high - b.noise.high, far_under = b.noise.low - h.range.low;
  s.below = under > least_side * over && far_under > least_side_range * far_over;
  s.above = !s.below || (over > least_side * under && far_over > least_side_range * far_under);
  s.empty = {s.below ? b.noise.low : -unbounded, s.above ? b.noise.high : unbounded};
  describe_rest(h, c, s);
  const double sign = s.above ? 1 : -1;
  const double edge = s.above ? b.noise.high : b.noise.low;
  const Pile pile = find_pile(h, s.above ? b.slope.high : b.slope.low, s.above ? 1 : -1);
  s.kind = pile.found ? ValueKind::solid : ValueKind::fog;
  s.object = pile.found ? pile.top : b.value + sign * s.mean;
  s.boundary = 0.5 * (s.background + s.object);
  if (!pile.found && s.above)
    s.boundary = edge + of_threshold * (otsu_threshold(h.all, h.range, b.value) - edge);
  if (sign * (s.boundary - edge) <= 0) s.boundary = 0.5 * (edge + s.object);
  if (!pile.found) return s;
  s.boundary = boundary_behind_haze(h, edge, pile, s.boundary);
  s.surface = surface_of(h, edge, pile, s.boundary);
  s.noise = pile_noise(h, pile.top, s.boundary);
  // Between the peaks there is room for more of the slope.
  const auto distance = [&](double v) { return std::fabs(v - s.background); };
  const auto clear = [&](double noise, double slope) {
    const double room = std::min(distance(slope), of_boundary * distance(s.boundary));
    return s.background + std::copysign(std::max(distance(noise), room), noise - s.background);
  };
  if (s.above) s.empty.high = clear(b.noise.high, b.slope.high);
  if (s.below) s.empty.low = clear(b.noise.low, b.slope.low);
  describe_rest(h, c, s);
  return s;
}

ValueSurvey survey_counts(const ValueCounts& c, std::optional<ValueKind> as) {
  ValueSurvey s;
  const Histogram h = working_histogram(c);
  s.background = c.air;
  if (std::accumulate(c.bins.begin(), c.bins.end(), uint64_t{0}) == 0) return s;
  std::vector<double> labels;
  const double value = c.source.low;
  if (h.all.empty() || (c.source.low == c.source.high && value != c.air)) {
    s.kind = ValueKind::constant;
    s.object = value, s.mean = std::fabs(value - c.air), s.boundary = 0.5 * (value + c.air);
    s.colors = {std::min(value, c.air), std::max(value, c.air)};
    s.above = value >= c.air, s.below = !s.above;
    s.empty = value == c.air ? Range{1, 0}
              : s.above      ? Range{-unbounded, s.boundary}
                             : Range{s.boundary, unbounded};
    s.crossing = std::max(2.0, std::cbrt(c.voxels));
    return s;
  }
  if (as == ValueKind::both_signs) return survey_signs(h, c);
  const bool quantity = as && as != ValueKind::labels;
  if ((!as || quantity) && !c.labels.value_or(false) && (c.level_set || is_level_set(h, c))) {
    s.kind = ValueKind::level_set, s.below = true;
    s.background = h.range.high;
    s.empty = {0, unbounded};
    describe_rest(h, c, s);
    s.boundary = 0;
    return s;
  }
  const bool said = c.labels.value_or(false), open = as || !c.labels;
  if (!quantity && ((said && list_labels(c, labels)) || (!said && open && find_labels(c, labels)))) {
    s.kind = ValueKind::labels, s.above = true;
    s.background = c.air < labels.front() ? c.air : labels.front() - 1, s.labels = labels;
    s.boundary = 0.5 * (s.background + labels.front());
    s.empty = {-unbounded, s.boundary};
    describe_rest(h, c, s);
    return s;
  }
  if (as && !quantity) return s;
  if (has_both_signs(h)) return survey_signs(h, c);
  const Background b = find_background(h, c);
  return b.found ? survey_object(h, c, b) : survey_dense(h, c);
}

} // namespace

ValueSurvey survey_values(const ValueCounts& c, std::optional<ValueKind> as) {
  ValueSurvey s = survey_counts(c, as);
  if (std::isnan(s.surface)) s.surface = s.boundary;
  s.data = c.data;
  return s;
}

ValueSurvey survey_part(const ValueSurvey& whole, const ValueCounts& part) {
  if (whole.kind != ValueKind::solid && whole.kind != ValueKind::fog) return whole;
  const Histogram h = working_histogram(part);
  if (h.all.empty()) return whole;
  ValueSurvey s = whole;
  describe_rest(h, part, s);
  s.crossing = whole.crossing;
  const bool any = s.lower.share > 0 || s.upper.share > 0;
  return any ? s : whole;
}

} // namespace bccsplat
