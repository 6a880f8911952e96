// SPDX-License-Identifier: Apache-2.0
// Shares the file's counts among bins over the range of the source, and measures the peaks of such bins.
#include "shade/value_histogram.h"

#include <cmath>
#include <numeric>

namespace bccsplat {

double Histogram::total() const { return std::accumulate(all.begin(), all.end(), 0.0); }

double Histogram::mass(double low, double high) const {
  double sum = 0;
  for (size_t i = 0; i < all.size(); ++i)
    if (const double v = value(static_cast<double>(i)); v >= low && v <= high) sum += all[i];
  return sum;
}

namespace {

constexpr int working_bins = 256;

// Shares samples that lie evenly between two values among the bins there: no bin is left out between two, or
// has the samples of two, and makes a valley or a peak.
void add_evenly(Histogram& h, const Range& values, double samples) {
  const size_t first = h.bin(values.low), last = h.bin(values.high);
  if (first == last || !(values.high > values.low)) {
    h.all[first] += samples;
    return;
  }
  for (size_t i = first; i <= last; ++i) {
    const double low = i == first ? values.low : h.value(static_cast<double>(i) - 0.5);
    const double high = i == last ? values.high : h.value(static_cast<double>(i) + 0.5);
    h.all[i] += samples * std::max(high - low, 0.0) / (values.high - values.low);
  }
}

} // namespace

Histogram working_histogram(const ValueCounts& c) {
  Histogram h;
  h.range = c.source;
  if (c.air_sites > 0) h.range = {std::min(h.range.low, c.air), std::max(h.range.high, c.air)};
  // What a damaged file says may have no width, or none that is a number.
  const auto wide = [](const Range& r) {
    const double width = (r.high - r.low) / working_bins;
    return width > 0 && std::isfinite(width) && std::isfinite(r.low);
  };
  if (!wide(h.range)) return h;
  h.all.resize(working_bins);
  const double step =
      wide(c.stored) ? (c.stored.high - c.stored.low) / static_cast<double>(c.bins.size()) : 0;
  for (size_t i = 0; i < c.bins.size(); ++i)
    add_evenly(
        h, {c.stored.low + static_cast<double>(i) * step, c.stored.low + static_cast<double>(i + 1) * step},
        static_cast<double>(c.bins[i]));
  h.stored = h.all;
  h.all[h.bin(c.air)] += static_cast<double>(c.air_sites);
  return h;
}

std::vector<double> smoothed(const std::vector<double>& bins, int reach) {
  std::vector<double> from = bins, to(bins.size());
  const auto n = static_cast<int>(bins.size());
  for (int pass = 0; pass < 2; ++pass, from.swap(to))
    for (int i = 0; i < n; ++i) {
      const int a = std::max(0, i - reach), b = std::min(n - 1, i + reach);
      to[i] = std::accumulate(from.begin() + a, from.begin() + b + 1, 0.0) / (b - a + 1);
    }
  return from;
}

double half_width(const std::vector<double>& bins, size_t peak, int step) {
  double n = 0;
  for (std::ptrdiff_t i = peak; bins[i] > 0.5 * bins[peak]; ++n) {
    i += step;
    if (i < 0 || i >= static_cast<std::ptrdiff_t>(bins.size())) return static_cast<double>(bins.size());
  }
  return n - 0.5;
}

double triangle_knee(const std::vector<double>& bins, size_t peak, int step) {
  const auto at = [&](std::ptrdiff_t i) { return bins[i]; };
  const std::ptrdiff_t from = peak;
  std::ptrdiff_t end = step > 0 ? static_cast<std::ptrdiff_t>(bins.size()) - 1 : 0;
  while (end != from && at(end) == 0) end -= step;
  double deepest = 0;
  std::ptrdiff_t knee = from;
  for (std::ptrdiff_t i = from; i != end; i += step) {
    const double f = static_cast<double>(i - from) / static_cast<double>(end - from);
    const double depth = (1 - f) * at(from) + f * at(end) - at(i);
    if (depth > deepest) deepest = depth, knee = i;
  }
  return static_cast<double>(knee);
}

double median_size(const Histogram& h) {
  std::vector<double> by_size(h.all.size());
  const double reach = std::max(-h.range.low, h.range.high),
               step = reach / static_cast<double>(by_size.size());
  for (size_t i = 0; i < h.all.size(); ++i) {
    const auto at = static_cast<size_t>(std::fabs(h.value(static_cast<double>(i))) / step);
    by_size[std::min(at, by_size.size() - 1)] += h.stored[i];
  }
  double left = 0.5 * std::accumulate(by_size.begin(), by_size.end(), 0.0);
  for (size_t i = 0; i < by_size.size(); ++i)
    if ((left -= by_size[i]) <= 0) return (static_cast<double>(i) + 1) * step;
  return reach;
}

double otsu_threshold(const std::vector<double>& bins, const Range& range, double low) {
  const double width = (range.high - range.low) / static_cast<double>(bins.size());
  const auto middle = [&](size_t i) { return range.low + (static_cast<double>(i) + 0.5) * width; };
  double count = 0, sum = 0;
  for (size_t i = 0; i < bins.size(); ++i)
    if (middle(i) >= low) count += bins[i], sum += bins[i] * middle(i);
  double below = 0, sum_below = 0, best = 0, threshold = low + 0.5 * (range.high - low);
  for (size_t i = 0; i < bins.size(); ++i) {
    if (middle(i) < low) continue;
    below += bins[i], sum_below += bins[i] * middle(i);
    if (below == 0 || below >= count) continue;
    const double apart = sum_below / below - (sum - sum_below) / (count - below);
    const double between = below * (count - below) * apart * apart;
    if (between > best) best = between, threshold = middle(i) + 0.5 * width;
  }
  return threshold;
}

} // namespace bccsplat
