// SPDX-License-Identifier: Apache-2.0
// Follows the references of a file from its root, inner blocks first, to set the checksums of chunks, pages,
// masks, corrections, metadata, root and header. References that lead out of the file
// stay as they are.
#include "sealed_file.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "formats/bcc4/coding/deflate.h"
#include "formats/bcc4/layout.h"
#include "formats/bcc4/page.h"

namespace fuzz {
namespace {

using namespace bccsplat;
using File = std::vector<std::byte>;

constexpr std::array<uint8_t, 13> column_ids{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13};
constexpr std::array<uint8_t, 13> column_widths{4, 4, 4, 4, 8, 4, 4, 4, 4, 4, 4, 1, 1};

template<class T> T get(std::span<const std::byte> bytes, size_t at) {
  T v{};
  std::memcpy(&v, bytes.data() + at, sizeof v);
  return v;
}
template<class T> void put(std::span<std::byte> bytes, size_t at, T v) {
  std::memcpy(bytes.data() + at, &v, sizeof v);
}

// A part of a file, or nothing when it does not lie in the file.
std::span<std::byte> part(File& file, uint64_t offset, uint64_t bytes) {
  if (offset < preamble_bytes || offset > file.size() || bytes > file.size() - offset) return {};
  return std::span(file).subspan(offset, bytes);
}

// Seals the chunks of a raw page as it is written, with no columns but the known ones: the bytes of a column
// come plane by plane.
void seal_page(File& file, std::span<std::byte> page) {
  if (page.size() < 8) return;
  const auto n = get<uint32_t>(page, 0), k = get<uint32_t>(page, 4);
  uint64_t at = 8 + uint64_t{k} * 4;
  if (k != column_ids.size() || n > max_page_entries || at + uint64_t{n} * 46 > page.size()) return;
  std::array<uint64_t, 14> first{}; // of each column, by id
  for (size_t c = 0; c < column_ids.size(); ++c) {
    if (static_cast<uint8_t>(page[8 + 4 * c]) != column_ids[c] ||
        static_cast<uint8_t>(page[9 + 4 * c]) != column_widths[c])
      return;
    first[column_ids[c]] = at;
    at += uint64_t{n} * column_widths[c];
  }
  const auto column = [&](size_t id, uint32_t i) {
    uint64_t v = 0;
    for (size_t b = 0; b < column_widths[id - 1]; ++b)
      v |= static_cast<uint64_t>(page[first[id] + b * n + i]) << (8 * b);
    return v;
  };
  uint64_t end = 0;
  for (uint32_t i = 0; i < n; ++i) {
    const uint64_t offset = end + column(5, i), bytes = (column(3, i) + column(4, i) + 7) / 8 * 8;
    end = offset + bytes;
    const auto chunk = part(file, offset, bytes);
    if (bytes == 0 || chunk.empty()) continue;
    const uint32_t crc = crc32_of(chunk);
    for (size_t b = 0; b < 4; ++b) page[first[11] + b * n + i] = static_cast<std::byte>(crc >> (8 * b));
  }
}

// Sets the checksum of the block whose reference is at `ref`; raw blocks are sealed inside first.
template<class Inside> void seal_block(File& file, std::span<std::byte> ref, const Inside& inside) {
  const uint64_t stored = get<uint32_t>(ref, 8);
  const auto bytes = part(file, get<uint64_t>(ref, 0), (stored + 7) / 8 * 8);
  if (bytes.empty()) return;
  if (get<uint32_t>(ref, 20) == 0) inside(bytes.first(stored));
  put(ref, 16, crc32_of(bytes));
}

constexpr auto nothing = [](std::span<std::byte>) {};

// Seals lists of blocks of a record, each a count with `head` bytes before it.
template<class Inside>
void seal_lists(File& file, std::span<std::byte> record, size_t head, const Inside& inside) {
  for (size_t at = head; at + 4 <= record.size(); at += head) {
    uint64_t blocks = get<uint32_t>(record, at);
    for (at += 4; blocks > 0 && at + block_ref_bytes <= record.size(); --blocks, at += block_ref_bytes)
      seal_block(file, record.subspan(at, block_ref_bytes), inside);
  }
}

// Seals the masks and corrections that raw metadata refers to: records 10, 11 and 0x8002.
void seal_frames(File& file, std::span<std::byte> metadata) {
  constexpr size_t entry_head = 16; // of a table: brick, bounds, count
  const auto seal_table = [&](std::span<std::byte> table) {
    for (size_t e = 4; e + entry_head + block_ref_bytes <= table.size(); e += entry_head + block_ref_bytes)
      seal_block(file, table.subspan(e + entry_head, block_ref_bytes), nothing);
  };
  for (size_t at = 0; at + 8 <= metadata.size();) {
    const auto type = get<uint16_t>(metadata, at);
    const uint64_t length = get<uint32_t>(metadata, at + 4);
    if (length > metadata.size() - at - 8) return;
    const auto record = metadata.subspan(at + 8, length);
    if (type == 10) seal_lists(file, record, 0, nothing);
    if (type == 11) seal_lists(file, record, 24, seal_table);  // behind step, bound, shape and base
    if (type == 0x8002) seal_lists(file, record, 16, nothing); // behind step and bound
    at += 8 + (length + 7) / 8 * 8;
  }
}

void seal_root(File& file) {
  const auto root = std::span(file).subspan(root_offset, root_bytes);
  seal_block(file, root.subspan(24, block_ref_bytes),
             [&](std::span<std::byte> metadata) { seal_frames(file, metadata); });
  seal_block(file, root.subspan(48, block_ref_bytes), [&](std::span<std::byte> directory) {
    for (size_t p = 0; p + page_ref_bytes <= directory.size() && p < 64 * page_ref_bytes; p += page_ref_bytes)
      seal_block(file, directory.subspan(p + 24, block_ref_bytes),
                 [&](std::span<std::byte> page) { seal_page(file, page); });
  });
  put(root, root_bytes - 4, crc32_of(root.first(root_bytes - 4)));
}

} // namespace

std::vector<std::byte> sealed_file(std::span<const uint8_t> input) {
  const auto bytes = std::as_bytes(input);
  File file(bytes.begin(), bytes.end());
  file.resize(std::max<size_t>(file.size(), preamble_bytes));
  seal_root(file);
  put(std::span(file), header_bytes - 4, crc32_of(std::span(file).first(header_bytes - 4)));
  return file;
}

} // namespace fuzz
