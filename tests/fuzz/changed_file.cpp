// SPDX-License-Identifier: Apache-2.0
// Follows the references of a file to its parts, takes one of them, and puts numbers into it that mean
// something to whoever reads it.
#include "changed_file.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <random>
#include <vector>

#include "formats/bcc4/layout.h"
#include "formats/bcc4/page.h"

namespace fuzz {
namespace {

using namespace bccsplat;
using Part = std::span<uint8_t>;

constexpr size_t metadata_at = 24, directory_at = 48; // in a root
constexpr size_t page_at = 24;                        // in a record of the directory
constexpr size_t column_bytes = 4, page_head = 8;

template<class T> T get(Part bytes, size_t at) {
  T v{};
  std::memcpy(&v, bytes.data() + at, sizeof v);
  return v;
}

// The input as the parts of a file; those that are not there are empty.
class Parts {
 public:
  explicit Parts(Part input) : input_(input) {
    if (input.size() < preamble_bytes) return;
    root = input.subspan(root_offset, root_bytes);
    metadata = block(root.subspan(metadata_at));
    directory = block(root.subspan(directory_at));
    for (size_t at = 0; at + 8 <= metadata.size();) {
      const uint64_t length = get<uint32_t>(metadata, at + 4);
      if (length > metadata.size() - at - 8) break;
      if (length > 0) records.push_back(metadata.subspan(at + 8, length));
      at += 8 + (length + 7) / 8 * 8;
    }
    for (size_t at = 0; at + page_ref_bytes <= directory.size(); at += page_ref_bytes) {
      pages.push_back(block(directory.subspan(at + page_at)));
      add_chunks(pages.back());
    }
  }

  Part root{}, metadata{}, directory{};
  std::vector<Part> records, pages, chunks;

 private:
  [[nodiscard]] Part part(uint64_t offset, uint64_t bytes) const {
    if (offset < preamble_bytes || offset > input_.size() || bytes > input_.size() - offset) return {};
    return input_.subspan(static_cast<size_t>(offset), bytes);
  }
  // Of a reference; deflated blocks are left alone.
  [[nodiscard]] Part block(Part ref) const {
    return get<uint32_t>(ref, 20) == 0 ? part(get<uint64_t>(ref, 0), get<uint32_t>(ref, 8)) : Part{};
  }
  void add_chunks(Part page) {
    if (page.size() < page_head) return;
    const uint64_t n = get<uint32_t>(page, 0), columns = get<uint32_t>(page, 4);
    constexpr std::array<uint64_t, 5> widths{4, 4, 4, 4, 8}; // slab, slot, values, runs, offset
    const uint64_t first = page_head + columns * column_bytes;
    if (n > max_page_entries || columns > 256 || first + n * 24 > page.size()) return;
    const auto number = [&](size_t column, uint64_t i) {
      uint64_t at = first, v = 0;
      for (size_t c = 0; c < column; ++c) at += n * widths[c];
      for (uint64_t b = 0; b < widths[column]; ++b) v |= uint64_t{page[at + b * n + i]} << (8 * b);
      return v;
    };
    uint64_t end = 0;
    for (uint64_t i = 0; i < n; ++i) {
      const uint64_t offset = end + number(4, i), bytes = number(2, i) + number(3, i);
      end = offset + (bytes + 7) / 8 * 8;
      if (const Part chunk = part(offset, bytes); !chunk.empty()) chunks.push_back(chunk);
    }
  }

  Part input_;
};

class Change {
 public:
  explicit Change(uint32_t seed) : random_(seed) {}
  [[nodiscard]] size_t below(size_t n) { return random_() % n; }
  [[nodiscard]] Part any(const std::vector<Part>& of) { return of.empty() ? Part{} : of[below(of.size())]; }

  void make(Part in) {
    constexpr std::array<int, 6> times{1, 1, 1, 2, 3, 6};
    for (int n = times[below(times.size())]; n > 0; --n) once(in);
  }

 private:
  void once(Part in) {
    const size_t at = below(in.size());
    switch (below(6)) {
    case 0:
    case 1:
      in[at] ^= static_cast<uint8_t>(1u << below(8));
      break;
    case 2:
      in[at] = static_cast<uint8_t>(random_());
      break;
    case 3:
      number(in.subspan(at & ~size_t{7}), doubles[below(doubles.size())]);
      break;
    default:
      number(in.subspan(at & ~size_t{3}), integers[below(integers.size())] >> 8 * (below(3) * 2));
    }
  }
  // As far as there is room.
  template<class T> void number(Part to, T v) {
    std::memcpy(to.data(), &v, std::min(to.size(), below(2) == 0 ? sizeof v : sizeof v / 2));
  }

  static constexpr std::array<uint64_t, 14> integers{0,
                                                     1,
                                                     2,
                                                     3,
                                                     255,
                                                     256,
                                                     65536,
                                                     1'000'000'000,
                                                     0x7fffffff,
                                                     0x80000000,
                                                     0xffffffff,
                                                     uint64_t{1} << 40,
                                                     0x7fffffffffffffff,
                                                     0xffffffffffffffff};
  static constexpr std::array<double, 10> doubles{0,      -1,  1e-300, 1e300, 0x1p-16,
                                                  0x1p16, 0.5, 3,      1e9,   __builtin_nan("")};
  std::mt19937 random_;
};

} // namespace

void change_file(std::span<uint8_t> input, uint32_t seed) {
  Parts parts(input);
  Change change(seed);
  const size_t kind = change.below(100);
  // Records of channels, lattices and lists are long, so that all are alike.
  Part chosen = kind < 45   ? change.any(parts.records)
                : kind < 60 ? change.any(parts.pages)
                : kind < 65 ? parts.directory
                : kind < 90 ? change.any(parts.chunks)
                : kind < 95 ? parts.root
                            : Part{};
  if (chosen.empty()) chosen = input;
  if (!chosen.empty()) change.make(chosen);
}

} // namespace fuzz
