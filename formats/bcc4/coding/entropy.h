// What bytes will take before they are coded: a fraction of a coder's time. In integers, so that choices do
// not hang on a machine's libm.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace bccsplat {

// About 256 log2(n), n at least 1.
[[nodiscard]] uint64_t log2_256(uint64_t n);

// Bits of symbols that occur so often at their own frequencies, times 256.
[[nodiscard]] uint64_t entropy_bits_256(std::span<const uint32_t> counts);
// The same with a Huffman code, in which no symbol has less than one bit: near what the best one takes,
// without its table.
[[nodiscard]] uint64_t huffman_bits_256(std::span<const uint32_t> counts);

// Of bytes as deflate codes them, tables left out: each by itself, and with runs of one byte as matches
// (zlib's Z_HUFFMAN_ONLY and Z_RLE).
struct DeflateBits {
  uint64_t alone_256 = 0, with_runs_256 = 0;
};
[[nodiscard]] DeflateBits deflate_bits(std::span<const std::byte> bytes);

} // namespace bccsplat
