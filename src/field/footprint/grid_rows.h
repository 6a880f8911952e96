// SPDX-License-Identifier: Apache-2.0
// Sums of kernel-weighted coefficients for a row of samples along x: the inner loop of dense sampling, many
// samples at a time.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "field/footprint/footprint.h"

namespace bccsplat {

// Samples of one axis against one coset, lengths in pitches: the first site strictly in reach and how far
// from it the sample lies.
struct AxisSamples {
  std::vector<int32_t> first;
  std::vector<float> from;
};
[[nodiscard]] AxisSamples axis_samples(const FootprintPlan& plan, size_t coset, size_t axis,
                                       std::span<const double> positions);

// A row of sites along x, and 1 minus its squared distance from the samples' row over the squared radius.
struct SiteRow {
  const float* value; // of site `base`, and on
  float u;
};

inline constexpr size_t grid_row_padding =
    16; // floats that index, from, sums and site rows may be read beyond

// sums[i] += coefficients of `rows` around sample i, weighted; first[i]: its first site, rising or falling.
void add_grid_row(const FootprintPlan& plan, std::span<const SiteRow> rows, int32_t base,
                  std::span<const int32_t> first, const float* from, float* sums);

} // namespace bccsplat
