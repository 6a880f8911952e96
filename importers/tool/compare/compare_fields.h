// SPDX-License-Identifier: Apache-2.0
// A field against samples on another grid, where both have values.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "tool/compare/sampled_series.h"
#include "tool/import/comparison.h"
#include "tool/json_fwd.h"
#include "tool/progress.h"

namespace bcc4 {

struct LargestDifference {
  uint64_t frame = 0; // and sample, of the samples
  double time = 0;
  std::array<uint64_t, 3> sample{};
  double first = 0, second = 0;
};

struct FieldDifference {
  std::string name; // of the channel
  Difference all;
  LargestDifference worst;
  std::array<double, 2> range{};                    // of the samples that were compared
  std::array<uint64_t, 2> missing{};                // values that only the first, and only the second lacks
  uint64_t samples_outside = 0, frames_outside = 0; // not compared: of a frame, and of all
  std::vector<FieldDifference> frames;

  void add(const FieldDifference& frame);
  [[nodiscard]] double peak() const { return all.count > 0 ? range[1] - range[0] : 0; }
  [[nodiscard]] bool within(double tolerance) const {
    return all.max <= tolerance && missing[0] == 0 && missing[1] == 0;
  }
};

// Compares channels of one name, or the only ones, at the samples and moments of `second` that lie in
// `first`. Throws where there are none, and where units differ that are not known together.
[[nodiscard]] std::vector<FieldDifference> compare_fields(const Volume& first, const std::string& first_name,
                                                          SampledSeries& second, Progress& progress);

// Throws unless the samples and moments of `second`, as many as the first has, are where the first has them.
// What its files do not tell is taken from the first.
void require_same_grid(const Volume& first, const std::string& first_name, SampledSeries& second);

[[nodiscard]] std::string psnr_words(const FieldDifference& difference);
[[nodiscard]] Json field_difference_json(const FieldDifference& difference, bool frames);

} // namespace bcc4
