// SPDX-License-Identifier: Apache-2.0
// Estimates by frequencies of bytes, with a logarithm of integers.
#include "formats/bcc4/coding/entropy.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

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

// Counts how often byte_of(value) has each value.
template<class T, class ByteOf>
[[nodiscard]] std::array<uint32_t, 256> count(std::span<const T> values, const ByteOf& byte_of) {
  // Several counts of each, as a count that has just been changed is slow to read.
  constexpr size_t tables = 4;
  std::array<std::array<uint32_t, 256>, tables> counts{};
  size_t i = 0;
  for (; i + tables <= values.size(); i += tables)
    for (size_t k = 0; k < tables; ++k) ++counts[k][byte_of(values[i + k])];
  for (; i < values.size(); ++i) ++counts[0][byte_of(values[i])];
  for (size_t v = 0; v < counts[0].size(); ++v) counts[0][v] += counts[1][v] + counts[2][v] + counts[3][v];
  return counts[0];
}

// Returns where the first of four equal bytes in a row is; bytes.size() or a place behind the last such:
// there are none.
[[nodiscard]] size_t find_run(std::span<const std::byte> bytes) {
  constexpr uint64_t low = 0x0101010101010101, high = low << 7;
  size_t i = 0;
  for (; i + 12 <= bytes.size(); i += 8) {
    // Bytes of `differ` are 0 where one equals the three behind it.
    const auto word = [&](size_t at) {
      uint64_t v;
      std::memcpy(&v, bytes.data() + i + at, sizeof v);
      return v;
    };
    const uint64_t first = word(0), differ = (first ^ word(1)) | (first ^ word(2)) | (first ^ word(3));
    if (const uint64_t zero = (differ - low) & ~differ & high; zero != 0)
      return i + static_cast<size_t>(std::countr_zero(zero)) / 8;
  }
  for (; i + 4 <= bytes.size(); ++i)
    if (bytes[i] == bytes[i + 1] && bytes[i] == bytes[i + 2] && bytes[i] == bytes[i + 3]) return i;
  return bytes.size();
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

std::array<uint32_t, 256> count_bytes(std::span<const std::byte> bytes) {
  return count(bytes, [](std::byte b) { return static_cast<size_t>(b); });
}

std::array<uint32_t, 256> count_bytes(std::span<const uint32_t> numbers, uint32_t shift) {
  return count(numbers, [shift](uint32_t v) { return size_t{v >> shift & 255}; });
}

DeflateBits deflate_bits(std::span<const std::byte> bytes) {
  constexpr size_t shortest = 3, longest = 258;
  const std::array<uint32_t, 256> alone = count_bytes(bytes);
  std::array<uint32_t, 256 + 29> with_runs{}; // literals, then lengths
  std::copy(alone.begin(), alone.end(), with_runs.begin());
  uint64_t extra = 0;
  for (size_t i = 0; i + shortest < bytes.size();) {
    const size_t to_run = find_run(bytes.subspan(i));
    const size_t first = i + to_run; // a literal, which is repeated
    if (first + shortest >= bytes.size()) break;
    const std::byte b = bytes[first];
    for (i = first + 1; i < bytes.size() && bytes[i] == b;) ++i;
    for (size_t again = i - first - 1; again >= shortest; again -= std::min(again, longest)) {
      const auto [length, bits] = length_symbol(std::min(again, longest));
      ++with_runs[256 + length];
      with_runs[static_cast<size_t>(b)] -= static_cast<uint32_t>(std::min(again, longest));
      extra += bits + 1; // and the only distance there is
    }
  }
  return {huffman_bits_256(alone), huffman_bits_256(with_runs) + 256 * extra};
}

} // namespace bccsplat
