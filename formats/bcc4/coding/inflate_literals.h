// SPDX-License-Identifier: Apache-2.0
// Inflates streams that are literals for the most part, as prediction residuals are: several at each look
// into a table.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace bccsplat {

// A code of deflate (RFC 1951, 3.2.2), of which a table tells the symbol of those of few bits.
template<unsigned table_bits> class HuffmanCode {
 public:
  static constexpr unsigned longest = 15;
  // A symbol and the bits of its code.
  struct Symbol {
    uint16_t value, bits;
  };

  // Takes the bits of each symbol's code, 0: it has none. Returns false unless they make a complete code.
  [[nodiscard]] bool set(std::span<const uint8_t> lengths);
  // The symbol whose code comes first in `bits`, which hold as many as the longest code has.
  [[nodiscard]] Symbol find(uint64_t bits) const;
  // Calls body(symbol, its code's first bit lowest) for the codes that are in the table.
  template<class Body> void for_short(const Body& body) const {
    for (size_t i = 0; i < short_; ++i) body(Symbol{sorted_[i], bits_[i]}, reversed_[i]);
  }

 private:
  std::array<Symbol, size_t{1} << table_bits> table_; // no bits: the code is longer
  std::array<uint16_t, longest + 1> count_;           // of codes, by their bits
  std::array<uint16_t, 288> sorted_, reversed_;       // symbols in the order of their codes, and those
  std::array<uint8_t, 288> bits_;
  size_t short_; // of these are in the table
};

class LiteralInflater {
 public:
  // Fills `out` and returns true if `bytes` is one whole stream of exactly that size. A stream for which it
  // returns false may still be one, with a code that is not complete. It stops behind the first `wanted`
  // bytes, of which it then knows no more than that they come first.
  [[nodiscard]] bool inflate(std::span<const std::byte> bytes, std::span<std::byte> out,
                             size_t wanted = SIZE_MAX);

 private:
  struct Stream;
  // Literals whose codes follow each other, and all of their bits: bits in the lowest byte, the number of
  // literals in the next one, and they themselves, first to last. None: the first symbol is something else.
  using Look = uint64_t;
  static constexpr unsigned look_bits = 10, most_literals = 6;

  [[nodiscard]] bool read_codes(Stream& s);
  void find_looks();
  [[nodiscard]] bool copy_stored(Stream& s) const;
  [[nodiscard]] bool decode_block(Stream& s, bool has_looks) const;
  // Decodes one symbol; `ended` tells whether it was the last of the block.
  [[nodiscard]] bool decode_symbol(Stream& s, bool& ended) const;

  HuffmanCode<look_bits> literals_;
  HuffmanCode<7> lengths_, distances_; // of codes; of matches
  // What follows in k bits, from 2^k on, for k up to look_bits.
  std::array<Look, size_t{2} << look_bits> looks_;
};

} // namespace bccsplat
