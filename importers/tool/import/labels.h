// SPDX-License-Identifier: Apache-2.0
// Labels: numbers of categories, between which there is nothing. A lattice that blends them makes up others.
#pragma once

#include <vector>

#include "tool/import/sample.h"

namespace bcc4 {

// Returns by channel whether it has labels: integers, or floats that are whole numbers or only two, of few
// values, most of them as their neighbours, that change by jumps rather than from one value to the next, or
// are very few and unevenly apart.
[[nodiscard]] std::vector<bool> find_labels(const SeriesDescription& series, const SeriesSample& sample,
                                            const std::vector<double>& air);

} // namespace bcc4
