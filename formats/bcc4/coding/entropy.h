// SPDX-License-Identifier: Apache-2.0
// Estimates how many bits a coder will need, in a fraction of its time. All in integers, so that choices do
// not depend on the libm of a machine.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace bccsplat {

// About 256 log2(n), n at least 1.
[[nodiscard]] uint64_t log2_256(uint64_t n);

// The entropy of symbols that occur `counts` times each, in bits times 256.
[[nodiscard]] uint64_t entropy_bits_256(std::span<const uint32_t> counts);
// The same for a Huffman code, in which no symbol has less than one bit: close to the best one, without its
// table.
[[nodiscard]] uint64_t huffman_bits_256(std::span<const uint32_t> counts);

// Counts how often each byte occurs.
[[nodiscard]] std::array<uint32_t, 256> count_bytes(std::span<const std::byte> bytes);
// Counts one byte of each number.
[[nodiscard]] std::array<uint32_t, 256> count_bytes(std::span<const uint32_t> numbers, uint32_t shift);

// The bits of bytes as deflate codes them, without tables: each byte by itself, and with runs of one byte as
// matches (Z_HUFFMAN_ONLY and Z_RLE of zlib).
struct DeflateBits {
  uint64_t alone_256 = 0, with_runs_256 = 0;
};
[[nodiscard]] DeflateBits deflate_bits(std::span<const std::byte> bytes);

} // namespace bccsplat
