// SPDX-License-Identifier: Apache-2.0
// Which values of a row are not 0, as bits.
#pragma once

#include <cstddef>
#include <cstdint>

namespace bccsplat {

// Sets bit i % 64 of words[i / 64] where row[i] is not 0 and clears it elsewhere, for the words that hold the
// first `count` bits. NaN is not 0.
void nonzero_bits(const float* row, size_t count, uint64_t* words);

} // namespace bccsplat
