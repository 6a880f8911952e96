// SPDX-License-Identifier: Apache-2.0
// The codes of values that are representable: the reverse of spread_codes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "formats/bcc4/coding/codes.h"
#include "points/brick.h"

namespace bccsplat {

// Finds the codes of the kept sites of a brick, in order, and returns how many there are; 0 also where a code
// does not give its value back, bit for bit. The type is of integers of one or two bytes.
[[nodiscard]] size_t find_codes(const SampleCoder& coder, const Brick& brick,
                                std::span<uint16_t, brick_sites> codes);

} // namespace bccsplat
