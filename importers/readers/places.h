// SPDX-License-Identifier: Apache-2.0
// Coordinates of the samples of an axis: even, uneven, or none.
#pragma once

#include <vector>

namespace bcc4 {

// Returns the distance of samples in the mean; 0 where there are not two.
[[nodiscard]] double mean_step(const std::vector<double>& at);
// Returns where they are as counted by even steps from the first sample to the last, 0 to n - 1; for two
// samples or more.
[[nodiscard]] std::vector<double> even_positions(const std::vector<double>& at);
// Returns whether all lie where even steps would put them, up to a thousandth of a step.
[[nodiscard]] bool evenly_spaced(const std::vector<double>& at);
// Returns whether they are finite and rise throughout or fall throughout.
[[nodiscard]] bool strictly_monotonic(const std::vector<double>& at);

} // namespace bcc4
