// SPDX-License-Identifier: Apache-2.0
// Tells labels from measurements by their neighbours along x, and refuses those that no file holds.
#include "choose/labels.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>

#include "base/error.h"
#include "choose/series_writer.h"
#include "series/text.h"

namespace bccsplat::series {
namespace {

// Two shares that tell labels from measurements: equal neighbours (noise has fewer), and neighbours that
// differ by more than one value in between (gradations hardly ever do, those of few values least of all).
constexpr double kAlike = 0.5, kJumps = 0.125, kJumpsOfFew = 0.03;
constexpr size_t kFew = 16;
// Smooth fields of bytes have more values. Then the shares have to be larger, and kInBlocks of the values to
// stand beside themselves more often than not, as only saturated ones do among measurements.
constexpr size_t kMany = 64, kMost = 1 << 16;
constexpr double kAlikeOfMany = 0.6, kJumpsOfMany = 0.25, kInBlocks = 0.75;
// Classes may lie in each other like shells; a gradation of few values would be in even steps then.
constexpr float kUneven = 1.5;

// The values of a channel, rising; empty: too many.
std::vector<float> values_of(const SeriesSample& sample, size_t channel) {
  std::vector<float> values;
  for (const SampleStretch& s : sample.stretches) {
    std::copy_if(s.values[channel].begin(), s.values[channel].end(), std::back_inserter(values),
                 [](float v) { return std::isfinite(v); });
    std::sort(values.begin(), values.end());
    values.erase(std::unique(values.begin(), values.end()), values.end());
    if (values.size() > kMost) return {};
  }
  return values;
}

bool in_even_steps(const std::vector<float>& values) {
  float least = INFINITY, most = 0;
  for (size_t i = 1; i < values.size(); ++i) {
    least = std::min(least, values[i] - values[i - 1]);
    most = std::max(most, values[i] - values[i - 1]);
  }
  return most < kUneven * least;
}

// Neighbours along x, all but those that are air both.
template<class Take> void each_pair(const SampleStretch& s, size_t channel, double air, const Take& take) {
  const std::vector<float>& v = s.values[channel];
  for (size_t row = 0; row < v.size(); row += s.box.dims[0])
    for (size_t i = row + 1; i < row + s.box.dims[0]; ++i) {
      const float a = v[i - 1], b = v[i];
      if (std::isfinite(a) && std::isfinite(b) && (a != b || a != air)) take(a, b);
    }
}

struct Neighbours {
  double all = 0, alike = 0, jumps = 0;
  double in_blocks = 0; // share of the values that have more neighbours like themselves than others
};

Neighbours compare_neighbours(const SeriesSample& sample, size_t channel, const std::vector<float>& values,
                              double air, Watch& watch) {
  const auto rank = [&](float v) {
    return std::lower_bound(values.begin(), values.end(), v) - values.begin();
  };
  Neighbours n;
  std::vector<int64_t> like_itself(values.size()); // neighbours that are, less those that are not
  for (const SampleStretch& s : sample.stretches) {
    watch.go_on();
    each_pair(s, channel, air, [&](float a, float b) {
      const auto first = rank(a), second = a == b ? first : rank(b);
      ++n.all;
      if (a == b)
        ++n.alike, like_itself[first] += 2;
      else
        --like_itself[first], --like_itself[second];
      if (std::abs(first - second) > 1) ++n.jumps;
    });
  }
  const auto blocks = std::count_if(like_itself.begin(), like_itself.end(), [](int64_t v) { return v > 0; });
  n.in_blocks = static_cast<double>(blocks) / static_cast<double>(values.size());
  return n;
}

// Noise ends here, before its values are listed.
bool mostly_alike(const SeriesSample& sample, size_t channel, double air) {
  double all = 0, alike = 0;
  for (const SampleStretch& s : sample.stretches)
    each_pair(s, channel, air, [&](float a, float b) { ++all, alike += a == b ? 1 : 0; });
  return alike >= kAlike * all;
}

// has_steps: a source of integers, scaled or not.
bool is_labels(const SeriesSample& sample, size_t channel, double air, bool has_steps, Watch& watch) {
  if (!mostly_alike(sample, channel, air)) return false;
  const std::vector<float> values = values_of(sample, channel);
  const bool whole =
      std::all_of(values.begin(), values.end(), [](float v) { return v == std::nearbyint(v); });
  if (values.size() < 2 || !(has_steps || whole || values.size() == 2)) return false;
  const Neighbours n = compare_neighbours(sample, channel, values, air, watch);
  if (n.alike < kAlike * n.all || n.alike == n.all) return false;
  if (values.size() == 2) return true; // there is nothing in between
  const double changes = n.all - n.alike;
  if (values.size() > kMany)
    return n.alike >= kAlikeOfMany * n.all && n.jumps > kJumpsOfMany * changes && n.in_blocks >= kInBlocks;
  const bool few = values.size() <= kFew;
  return (few && !in_even_steps(values)) || n.jumps > (few ? kJumpsOfFew : kJumps) * changes;
}

} // namespace

std::vector<bool> find_labels(const SeriesDescription& series, const SeriesSample& sample,
                              const std::vector<double>& air, Watch& watch) {
  std::vector<bool> labels;
  for (size_t c = 0; c < series.channels.size(); ++c)
    labels.push_back(series.channels[c].labels
                         ? *series.channels[c].labels
                         : is_labels(sample, c, air[c], source_step(series.channels[c]) > 0, watch));
  return labels;
}

void require_exact_labels(const SeriesDescription& series, const std::vector<ChannelScan>& ranges,
                          const std::vector<double>& air) {
  constexpr double exact = 1 << 24; // whole numbers up to this are, as floats
  for (size_t c = 0; c < ranges.size(); ++c) {
    if (ranges[c].empty() || !has_wide_integers(series.channels[c])) continue;
    const auto reach = [&](double v) { return std::max(std::abs(v), std::abs(v - air[c])); };
    if (std::max(reach(ranges[c].min), reach(ranges[c].max)) > exact)
      throw Error(
          Code::limit_exceeded,
          concat(
              series.files.front().path, ": channel '", series.channels[c].name, "' has labels, ",
              ranges[c].min, " to ", ranges[c].max,
              ", and whole numbers come back exactly up to 16777216: number the labels anew, such as 0, 1, "
              "2 ..., or store them as values that may be off, on a Cartesian lattice (cc)"));
  }
}

} // namespace bccsplat::series
