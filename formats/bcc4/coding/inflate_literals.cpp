// SPDX-License-Identifier: Apache-2.0
// Decodes blocks of deflate (RFC 1951). The bits that come next are looked up in a table of as many literals
// as their codes fill; all other symbols are decoded one by one, as are those near the ends of the stream and
// of what it becomes.
#include "formats/bcc4/coding/inflate_literals.h"

#include <algorithm>
#include <cstring>

namespace bccsplat {
namespace {

constexpr unsigned end_of_block = 256, first_length = 257;
constexpr size_t literal_codes = 286, distance_codes = 30; // that have a meaning

struct Extra {
  uint16_t base;
  uint8_t bits;
};
constexpr std::array<Extra, 29> length_of = {
    {{3, 0},  {4, 0},  {5, 0},  {6, 0},   {7, 0},   {8, 0},   {9, 0},   {10, 0},  {11, 1}, {13, 1},
     {15, 1}, {17, 1}, {19, 2}, {23, 2},  {27, 2},  {31, 2},  {35, 3},  {43, 3},  {51, 3}, {59, 3},
     {67, 4}, {83, 4}, {99, 4}, {115, 4}, {131, 5}, {163, 5}, {195, 5}, {227, 5}, {258, 0}}};
constexpr std::array<Extra, distance_codes> distance_of = {
    {{1, 0},     {2, 0},     {3, 0},     {4, 0},      {5, 1},      {7, 1},     {9, 2},     {13, 2},
     {17, 3},    {25, 3},    {33, 4},    {49, 4},     {65, 5},     {97, 5},    {129, 6},   {193, 6},
     {257, 7},   {385, 7},   {513, 8},   {769, 8},    {1025, 9},   {1537, 9},  {2049, 10}, {3073, 10},
     {4097, 11}, {6145, 11}, {8193, 12}, {12289, 12}, {16385, 13}, {24577, 13}}};

[[nodiscard]] unsigned reversed(unsigned code, unsigned bits) {
  code = (code & 0x5555) << 1 | (code >> 1 & 0x5555);
  code = (code & 0x3333) << 2 | (code >> 2 & 0x3333);
  code = (code & 0x0f0f) << 4 | (code >> 4 & 0x0f0f);
  code = (code & 0x00ff) << 8 | (code >> 8 & 0x00ff);
  return code >> (16 - bits);
}

} // namespace

template<unsigned table_bits> bool HuffmanCode<table_bits>::set(std::span<const uint8_t> lengths) {
  count_.fill(0);
  for (const uint8_t n : lengths) ++count_[n];
  count_[0] = 0;
  // Begin of the codes of each length, and of their symbols among the sorted ones.
  std::array<unsigned, 17> code{}, at{};
  static_assert(longest + 1 < code.size());
  for (unsigned n = 1; n <= longest; ++n) {
    code[n + 1] = (code[n] + count_[n]) << 1;
    at[n + 1] = at[n] + count_[n];
    if (code[n] + count_[n] > 1u << n) return false;
  }
  if (code[longest] + count_[longest] != 1u << longest) return false;
  short_ = at[std::min(table_bits, longest) + 1];
  table_.fill({0, 0});
  for (size_t i = 0; i < lengths.size(); ++i) {
    const unsigned n = lengths[i];
    if (n == 0) continue;
    const size_t k = at[n]++;
    sorted_[k] = static_cast<uint16_t>(i);
    reversed_[k] = static_cast<uint16_t>(reversed(code[n]++, n));
    bits_[k] = static_cast<uint8_t>(n);
    for (size_t j = reversed_[k]; n <= table_bits && j < table_.size(); j += size_t{1} << n)
      table_[j] = {sorted_[k], bits_[k]};
  }
  return true;
}

template<unsigned table_bits>
typename HuffmanCode<table_bits>::Symbol HuffmanCode<table_bits>::find(uint64_t bits) const {
  if (const Symbol s = table_[bits & (table_.size() - 1)]; s.bits != 0) return s;
  unsigned code = 0, first = 0, index = 0;
  for (unsigned n = 1; n <= longest; ++n) {
    code = code << 1 | static_cast<unsigned>(bits >> (n - 1) & 1);
    first <<= 1;
    if (code - first < count_[n]) return {sorted_[index + code - first], static_cast<uint16_t>(n)};
    first += count_[n], index += count_[n];
  }
  return {0, 0};
}

struct LiteralInflater::Stream {
  const std::byte *in, *in_end;
  std::byte *out_begin, *out, *out_end;
  std::byte* out_stop; // where it may stop, out_end: at the end of the stream alone
  uint64_t held = 0;   // bits that come next; those behind `count` may be there or not
  unsigned count = 0;  // at most 63

  [[nodiscard]] bool has_word() const { return in_end - in >= 8; }
  // Holds at least 56 bits; a word must be there.
  void refill_word() {
    uint64_t word;
    std::memcpy(&word, in, sizeof word);
    held |= word << count;
    in += (63 - count) >> 3;
    count |= 56;
  }
  // Returns whether all that was asked for is there, which is less than the stream holds.
  [[nodiscard]] bool stops() const { return out >= out_stop && out_stop != out_end; }
  // Holds as many bits as there are, at most 63.
  void refill() {
    if (has_word()) return refill_word();
    for (; count < 56 && in < in_end; count += 8) held |= std::to_integer<uint64_t>(*in++) << count;
  }
  void drop(unsigned bits) { held >>= bits, count -= bits; }
  // Returns whether they were there.
  [[nodiscard]] bool take(unsigned bits, unsigned& value) {
    value = static_cast<unsigned>(held & ((uint64_t{1} << bits) - 1));
    if (bits > count) return false;
    drop(bits);
    return true;
  }
};

bool LiteralInflater::read_codes(Stream& s) {
  unsigned literals = 0, distances = 0, of_lengths = 0;
  s.refill();
  if (!s.take(5, literals) || !s.take(5, distances) || !s.take(4, of_lengths)) return false;
  literals += 257, distances += 1, of_lengths += 4;
  if (literals > literal_codes || distances > distance_codes) return false;
  constexpr std::array<uint8_t, 19> order = {16, 17, 18, 0, 8,  7, 9,  6, 10, 5,
                                             11, 4,  12, 3, 13, 2, 14, 1, 15};
  std::array<uint8_t, 19> lengths{};
  for (unsigned i = 0; i < of_lengths; ++i) {
    unsigned n = 0;
    s.refill();
    if (!s.take(3, n)) return false;
    lengths[order[i]] = static_cast<uint8_t>(n);
  }
  if (!lengths_.set(lengths)) return false;
  std::array<uint8_t, literal_codes + distance_codes> all{};
  for (size_t i = 0; i < literals + distances;) {
    s.refill();
    const auto symbol = lengths_.find(s.held);
    if (symbol.bits == 0 || symbol.bits > s.count) return false;
    s.drop(symbol.bits);
    if (symbol.value < 16) {
      all[i++] = static_cast<uint8_t>(symbol.value);
      continue;
    }
    constexpr std::array<Extra, 3> repeats = {{{3, 2}, {3, 3}, {11, 7}}};
    const Extra& repeat = repeats[symbol.value - 16u];
    unsigned times = 0;
    if (!s.take(repeat.bits, times)) return false;
    times += repeat.base;
    if (times > literals + distances - i || (symbol.value == 16 && i == 0)) return false;
    std::fill_n(all.begin() + i, times, symbol.value == 16 ? all[i - 1] : uint8_t{0});
    i += times;
  }
  const auto of_literals = std::span(all).first(literals),
             of_distances = std::span(all).subspan(literals, distances);
  return of_literals[end_of_block] != 0 && literals_.set(of_literals) && distances_.set(of_distances);
}

// A literal and what follows in the bits that it leaves. Where that is as many as there is room for, fewer.
void LiteralInflater::find_looks() {
  looks_[1] = 0;
  for (unsigned k = 1; k <= look_bits; ++k) {
    const auto with_bits = [&](unsigned bits) { return looks_.data() + (size_t{1} << bits); };
    std::fill_n(with_bits(k), size_t{1} << k, Look{0});
    literals_.for_short([&](const auto& symbol, size_t code) {
      if (symbol.bits > k || symbol.value >= end_of_block) return;
      const unsigned left = k - symbol.bits;
      const Look first = uint64_t{symbol.value} << 16 | 1u << 8 | symbol.bits;
      for (size_t i = 0; i < size_t{1} << left; ++i) {
        Look rest = with_bits(left)[i];
        if ((rest >> 8 & 7) == most_literals) rest = with_bits(left / 2)[i & ((size_t{1} << left / 2) - 1)];
        with_bits(k)[code + (i << symbol.bits)] = first + (rest & 0xffff) + (rest >> 16 << 24);
      }
    });
  }
}

bool LiteralInflater::copy_stored(Stream& s) const {
  s.drop(s.count & 7);
  s.refill();
  unsigned size = 0, inverse = 0;
  if (!s.take(16, size) || !s.take(16, inverse) || (size ^ inverse) != 0xffff) return false;
  // What is held goes back.
  s.in -= s.count / 8;
  s.held = 0, s.count = 0;
  if (s.in_end - s.in < size || s.out_end - s.out < size) return false;
  s.out = std::copy_n(s.in, size, s.out);
  s.in += size;
  return true;
}

bool LiteralInflater::decode_symbol(Stream& s, bool& ended) const {
  s.refill(); // enough for a length and a distance
  const auto symbol = literals_.find(s.held);
  if (symbol.bits == 0 || symbol.bits > s.count) return false;
  s.drop(symbol.bits);
  ended = symbol.value == end_of_block;
  if (ended) return true;
  if (symbol.value < end_of_block) {
    if (s.out == s.out_end) return false;
    *s.out++ = static_cast<std::byte>(symbol.value);
    return true;
  }
  unsigned length = 0, distance = 0;
  if (symbol.value >= literal_codes || !s.take(length_of[symbol.value - first_length].bits, length))
    return false;
  length += length_of[symbol.value - first_length].base;
  const auto far = distances_.find(s.held);
  if (far.bits == 0 || far.bits > s.count || far.value >= distance_codes) return false;
  s.drop(far.bits);
  if (!s.take(distance_of[far.value].bits, distance)) return false;
  distance += distance_of[far.value].base;
  if (s.out - s.out_begin < distance || s.out_end - s.out < length) return false;
  if (distance == 1)
    std::fill_n(s.out, length, s.out[-1]);
  else
    for (unsigned i = 0; i < length; ++i) s.out[i] = s.out[static_cast<std::ptrdiff_t>(i) - distance];
  s.out += length;
  return true;
}

bool LiteralInflater::decode_block(Stream& stream, bool has_looks) const {
  constexpr unsigned looks = 5; // as many as are sure to have their bits
  static_assert(looks * look_bits <= 56);
  constexpr std::ptrdiff_t room = looks * most_literals + 2;
  const Look* const table = looks_.data() + (size_t{1} << look_bits);
  Stream s = stream; // its members stay in registers
  for (bool ended = false; !ended && !s.stops();) {
    while (has_looks && s.has_word() && s.out_stop - s.out >= room) {
      s.refill_word();
      bool other = false;
      for (unsigned i = 0; i < looks && !other; ++i) {
        const Look look = table[s.held & ((1u << look_bits) - 1)];
        const uint64_t literals = look >> 16;
        std::memcpy(s.out, &literals, sizeof literals);
        s.out += look >> 8 & 7;
        s.drop(static_cast<unsigned>(look & 15));
        other = (look & 15) == 0;
      }
      if (other) break;
    }
    if (!decode_symbol(s, ended)) return false;
  }
  stream = s;
  return true;
}

bool LiteralInflater::inflate(std::span<const std::byte> bytes, std::span<std::byte> out, size_t wanted) {
  Stream s{bytes.data(), bytes.data() + bytes.size(), out.data(),
           out.data(),   out.data() + out.size(),     out.data() + std::min(wanted, out.size())};
  for (bool last = false; !last && !s.stops();) {
    unsigned final_block = 0, type = 0;
    s.refill();
    if (!s.take(1, final_block) || !s.take(2, type)) return false;
    last = final_block != 0;
    if (type == 0) {
      if (!copy_stored(s)) return false;
      continue;
    }
    if (type != 2 || !read_codes(s)) return false;
    // The table pays for itself where what is left is more than a few times its size.
    const bool many = s.out_stop - s.out > 2048;
    if (many) find_looks();
    if (!decode_block(s, many)) return false;
  }
  if (s.stops()) return true;
  // Whole bytes that are held have not been used.
  return s.out == s.out_end && s.in - s.count / 8 == s.in_end;
}

} // namespace bccsplat
