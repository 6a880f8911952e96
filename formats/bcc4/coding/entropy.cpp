// SPDX-License-Identifier: Apache-2.0
#include "formats/bcc4/coding/entropy.h"

#include <algorithm>
#include <array>
#include <bit>

namespace bccsplat {
namespace {

// The symbol of the length of a match, 3 .. 258, counted from that of length 3, and its extra bits (RFC 1951,
// 3.2.5).
struct LengthSymbol {
  size_t symbol;
  uint32_t extra;
};
[[nodiscard]] LengthSymbol length_symbol(size_t length) {
  if (length == 258) return {28, 0};
  const size_t v = length - 3;
  if (v < 8) return {v, 0};
  const auto extra = static_cast<uint32_t>(std::bit_width(v)) - 3;
  return {4 * extra + (v >> extra), extra};
}

} // namespace

uint64_t log2_256(uint64_t n) {
  const auto e = static_cast<int>(std::bit_width(n)) - 1;
  return static_cast<uint64_t>(e) * 256 + ((n << 8) >> e) - 256;
}

uint64_t entropy_bits_256(std::span<const uint32_t> counts) {
  uint64_t all = 0, bits = 0;
  for (const uint32_t n : counts) {
    all += n;
    if (n > 1) bits += n * log2_256(n);
  }
  return all == 0 ? 0 : all * log2_256(all) - bits;
}

uint64_t huffman_bits_256(std::span<const uint32_t> counts) {
  uint64_t all = 0, bits = 0; // of the symbols left: their number, and the sum of n log n
  for (const uint32_t n : counts) {
    all += n;
    if (n > 1) bits += n * log2_256(n);
  }
  // A symbol that makes up half of all has one bit; each of the others has one bit more.
  uint64_t decided = 0;
  for (uint32_t last = UINT32_MAX; all > 0;) {
    uint32_t largest = 0;
    for (const uint32_t n : counts)
      if (n < last) largest = std::max(largest, n);
    if (2 * uint64_t{largest} < all || largest == 0) break;
    decided += 256 * all;
    all -= largest;
    bits -= largest * log2_256(largest);
    last = largest;
  }
  return decided + (all == 0 ? 0 : all * log2_256(all) - bits);
}

DeflateBits deflate_bits(std::span<const std::byte> bytes) {
  constexpr size_t shortest = 3, longest = 258;
  std::array<uint32_t, 256> alone{};
  std::array<uint32_t, 256 + 29> with_runs{}; // literals, then lengths
  uint64_t extra = 0;
  for (size_t i = 0; i < bytes.size();) {
    const std::byte b = bytes[i];
    size_t end = i + 1;
    while (end < bytes.size() && bytes[end] == b) ++end;
    const auto symbol = static_cast<size_t>(b);
    alone[symbol] += static_cast<uint32_t>(end - i);
    size_t again = end - i - 1; // after a first one, which is a literal
    i = end;
    ++with_runs[symbol];
    for (; again >= shortest; again -= std::min(again, longest)) {
      const auto [length, bits] = length_symbol(std::min(again, longest));
      ++with_runs[256 + length];
      extra += bits + 1; // and the only distance there is
    }
    with_runs[symbol] += static_cast<uint32_t>(again);
  }
  return {huffman_bits_256(alone), huffman_bits_256(with_runs) + 256 * extra};
}

} // namespace bccsplat
