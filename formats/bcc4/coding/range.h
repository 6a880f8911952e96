// SPDX-License-Identifier: Apache-2.0
// The smallest and the largest of packed codes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace bccsplat {

// `packed` holds codes of 1, 2 or 4 bytes each. Without any code the first number is all ones and the second
// 0.
[[nodiscard]] std::array<uint32_t, 2> packed_range(std::span<const std::byte> packed, uint32_t bytes);

} // namespace bccsplat
