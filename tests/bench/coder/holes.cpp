// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/coder/holes.h"

#include <array>
#include <cmath>
#include <utility>

#include "base/error.h"

namespace bccsplat::bench {
namespace {

// Fills those holes that have a known neighbour; the others stay in the list.
void fill_rim(TrialSeries& series, std::vector<size_t>& holes) {
  std::array<size_t, 5> stride{1};
  for (size_t a = 0; a < 4; ++a) stride[a + 1] = stride[a] * series.dims[a];
  std::vector<size_t> left;
  std::vector<std::pair<size_t, float>> found;
  for (const size_t i : holes) {
    float sum = 0;
    int count = 0;
    const auto look = [&](size_t j) {
      if (std::isfinite(series.values[j])) sum += series.values[j], ++count;
    };
    for (size_t a = 0; a < 4; ++a) {
      const size_t at = i % stride[a + 1] / stride[a];
      if (at > 0) look(i - stride[a]);
      if (at + 1 < static_cast<size_t>(series.dims[a])) look(i + stride[a]);
    }
    if (count > 0)
      found.emplace_back(i, sum / static_cast<float>(count));
    else
      left.push_back(i);
  }
  for (const auto& [i, v] : found) series.values[i] = v;
  holes = std::move(left);
}

} // namespace

TrialSeries without_holes(const TrialSeries& series) {
  TrialSeries filled = series;
  std::vector<size_t> holes;
  for (size_t i = 0; i < filled.values.size(); ++i)
    if (!std::isfinite(filled.values[i])) holes.push_back(i);
  if (holes.size() == filled.values.size()) fail(Code::invalid_argument, "the series has no value at all");
  while (!holes.empty()) fill_rim(filled, holes);
  return filled;
}

} // namespace bccsplat::bench
