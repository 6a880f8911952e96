// SPDX-License-Identifier: Apache-2.0
// Occupancy rows <-> run lists: (skip, run) pairs of variable-length integers over the sites of rows laid end
// to end.
//
// Canonical form, the only one accepted: every run and every skip is at least 1, only the first skip may be
// 0, sites after the last run are clear and not coded. A run goes on across row ends, so a full brick is one
// pair.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "base/bytes.h"
#include "points/brick.h"

namespace bccsplat {

class RunEncoder {
 public:
  explicit RunEncoder(ByteWriter& out) : out_(out) {}
  // Takes the next `width` sites, 0 .. 16; bit x is site x, bits from `width` on must be clear.
  void row(uint16_t bits, int width);
  // Writes the last run.
  void finish();

 private:
  ByteWriter& out_;
  uint64_t skip_ = 0, run_ = 0;
};

class RunDecoder {
 public:
  // All rows together have `sites` sites, of which `kept` are set. Throws corrupt or truncated with the place
  // in the file.
  RunDecoder(ByteReader& in, uint64_t sites, uint64_t kept) : in_(in), sites_(sites), kept_(kept) {}
  [[nodiscard]] uint16_t row(int width) {
    const uint64_t n = width;
    if (skip(n)) return 0;
    if (skip_ > 0 || run_ < n) return mixed_row(width);
    run_ -= n;
    return static_cast<uint16_t>((1u << width) - 1);
  }
  // Fills the next rows, of sixteen sites each, which must be clear before.
  void fill(std::span<uint16_t> rows);
  // Passes over the next sites if none of them is set, as far as one pair says.
  [[nodiscard]] bool skip(uint64_t sites) {
    if (skip_ < sites) return false;
    skip_ -= sites;
    return true;
  }
  // Checks that all kept sites have come.
  void finish() const;

 private:
  void next_pair();
  [[noreturn]] void refuse_pair() const;
  [[nodiscard]] uint16_t mixed_row(int width);

  ByteReader& in_;
  uint64_t sites_, kept_;       // not yet covered by a pair
  uint64_t skip_ = 0, run_ = 0; // left of the current pair
  bool first_ = true;
};

// Returns the bits of `bits` at the set bits of `mask`, pushed together at the low end.
[[nodiscard]] uint16_t compress_bits(uint16_t bits, uint16_t mask);
// The reverse: the low bits of `bits` spread to the set bits of `mask`.
[[nodiscard]] uint16_t expand_bits(uint16_t bits, uint16_t mask);

// The index of the first value of each row in the list of kept values; the last entry is their number.
using RowIndex = std::array<uint16_t, brick_rows + 1>;
[[nodiscard]] RowIndex row_index(const BrickMask& kept);

} // namespace bccsplat
