// SPDX-License-Identifier: Apache-2.0
// Labels: numbers of categories, between which there is nothing. A lattice that blends them makes up others.
#pragma once

#include <vector>

#include "choose/sample.h"

namespace bccsplat::series {

// Returns by channel whether it has labels: the source says it, or they are integers, or floats that are
// whole numbers or only two, most of them as their neighbours, that change by jumps rather than from one
// value to the next, or are very few and unevenly apart. Where there are many values, most stand in blocks.
[[nodiscard]] std::vector<bool> find_labels(const SeriesDescription& series, const SeriesSample& sample,
                                            const std::vector<double>& air, Watch& watch);

// Throws for labels that are larger integers than floats tell apart. ranges: of all frames, by channel.
void require_exact_labels(const SeriesDescription& series, const std::vector<ChannelScan>& ranges,
                          const std::vector<double>& air);

} // namespace bccsplat::series
