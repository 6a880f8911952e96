// SPDX-License-Identifier: Apache-2.0
// Round numbers for scales, and how they are written.
#pragma once

#include <string>
#include <vector>

namespace bcc4 {

// The largest of 1, 2 and 5 times a power of ten that is not above `value`, which is positive.
[[nodiscard]] double round_below(double value);
// Multiples of a round step within [low, high], at most `most` of them (2 or more).
[[nodiscard]] std::vector<double> round_ticks(double low, double high, size_t most);
// Numbers as texts with the same digits behind the point, as many as tell them apart; very large and very
// small ones with exponents.
[[nodiscard]] std::vector<std::string> tick_texts(const std::vector<double>& values);

} // namespace bcc4
