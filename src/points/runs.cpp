// SPDX-License-Identifier: Apache-2.0
// Writes and reads run lists, and moves bits between masks.
#include "points/runs.h"

#include <algorithm>
#include <bit>

namespace bccsplat {

void RunEncoder::row(uint16_t bits, int width) {
  int x = 0;
  while (x < width) {
    const auto rest = static_cast<uint16_t>(bits >> x);
    if (rest & 1) {
      const int n = std::min(std::countr_one(rest), width - x);
      run_ += n;
      x += n;
    } else {
      if (run_ > 0) finish();
      const int n = std::min(std::countr_zero(rest), width - x);
      skip_ += n;
      x += n;
    }
  }
}

void RunEncoder::finish() {
  if (run_ == 0) return;
  out_.write_varint(skip_);
  out_.write_varint(run_);
  skip_ = run_ = 0;
}

void RunDecoder::next_pair() {
  skip_ = in_.read_varint();
  run_ = in_.read_varint();
  if (run_ == 0 || (skip_ == 0 && !first_) || run_ > kept_ || skip_ > sites_ - kept_) refuse_pair();
  sites_ -= skip_ + run_;
  kept_ -= run_;
  first_ = false;
}

void RunDecoder::refuse_pair() const {
  if (run_ == 0 || (skip_ == 0 && !first_))
    fail(Code::corrupt, "run list: pair (", skip_, ", ", run_, ") is empty or not canonical");
  fail(Code::corrupt, "run list: pair (", skip_, ", ", run_, ") goes beyond the ", kept_, " sites of ",
       sites_, " that are left");
}

uint16_t RunDecoder::mixed_row(int width) {
  unsigned bits = 0;
  int x = 0;
  while (x < width) {
    if (run_ == 0) {
      if (kept_ == 0) break;
      next_pair();
    }
    const auto skip = static_cast<int>(std::min<uint64_t>(skip_, width - x));
    skip_ -= skip;
    x += skip;
    if (skip_ > 0) break;
    const auto run = static_cast<int>(std::min<uint64_t>(run_, width - x));
    bits |= ((1u << run) - 1) << x;
    run_ -= run;
    x += run;
  }
  // The next pair is read already, so that what it skips can be passed over at once.
  if (run_ == 0 && kept_ > 0) next_pair();
  return static_cast<uint16_t>(bits);
}

void RunDecoder::fill(std::span<uint16_t> rows) {
  const uint64_t end = rows.size() * brick_edge;
  for (uint64_t at = 0; at < end;) {
    if (run_ == 0) {
      if (kept_ == 0) return;
      next_pair();
    }
    const uint64_t skip = std::min(skip_, end - at);
    skip_ -= skip;
    at += skip;
    if (at == end) return;
    uint64_t run = std::min(run_, end - at);
    run_ -= run;
    for (; run > 0;) {
      const auto x = static_cast<unsigned>(at % brick_edge);
      const auto n = static_cast<unsigned>(std::min<uint64_t>(run, brick_edge - x));
      uint16_t& row = rows[at / brick_edge];
      row = static_cast<uint16_t>(row | ((1u << n) - 1) << x);
      at += n;
      run -= n;
    }
  }
}

void RunDecoder::finish() const {
  if (kept_ + run_ > 0) fail(Code::corrupt, "run list: ", kept_ + run_, " kept sites lie outside the rows");
}

uint16_t compress_bits(uint16_t bits, uint16_t mask) {
  unsigned out = 0;
  int n = 0;
  for (unsigned m = mask; m; m &= m - 1, ++n) out |= (bits & (m & -m) ? 1u : 0u) << n;
  return static_cast<uint16_t>(out);
}

uint16_t expand_bits(uint16_t bits, uint16_t mask) {
  unsigned out = 0;
  int n = 0;
  for (unsigned m = mask; m; m &= m - 1, ++n)
    if (bits >> n & 1) out |= m & -m;
  return static_cast<uint16_t>(out);
}

RowIndex row_index(const BrickMask& kept) {
  RowIndex index;
  index[0] = 0;
  for (size_t r = 0; r < brick_rows; ++r)
    index[r + 1] = static_cast<uint16_t>(index[r] + std::popcount(kept[r]));
  return index;
}

} // namespace bccsplat
