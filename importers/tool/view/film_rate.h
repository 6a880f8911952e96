// SPDX-License-Identifier: Apache-2.0
// Pictures a second of films where nobody says it.
#pragma once

#include <array>
#include <cstdint>

namespace bcc4 {

inline constexpr std::array<int32_t, 2> usual_rate{24, 1}; // numerator and denominator

} // namespace bcc4
