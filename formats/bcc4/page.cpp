// SPDX-License-Identifier: Apache-2.0
// Writes and reads index pages, column by column, and their directory; every entry that is read is checked.
#include "formats/bcc4/page.h"

#include <algorithm>
#include <array>
#include <tuple>

#include "base/bytes.h"
#include "formats/bcc4/coding/chunk_rows.h"
#include "formats/bcc4/coding/codes.h"
#include "formats/bcc4/coding/predict.h"
#include "formats/bcc4/counts.h"

namespace bccsplat {
namespace {

// The columns of a page. A reader skips columns from 128 on that it does not know, and must refuse others.
struct Column {
  uint8_t id, width;
};
constexpr std::array<Column, 13> columns{{{1, 4},    // slab
                                          {2, 4},    // slot
                                          {3, 4},    // values_bytes
                                          {4, 4},    // runs_bytes
                                          {5, 8},    // offset, after the sizes: see column_base
                                          {6, 4},    // runs_decoded
                                          {7, 4},    // kept
                                          {8, 4},    // holes
                                          {9, 4},    // min_code
                                          {10, 4},   // max_code
                                          {11, 4},   // crc
                                          {12, 1},   // coding
                                          {13, 1}}}; // predictor

[[nodiscard]] uint64_t get_column(const Bcc4Chunk& c, uint8_t id) {
  switch (id) {
  case 1:
    return static_cast<uint32_t>(c.slab);
  case 2:
    return c.slot;
  case 3:
    return c.values_bytes;
  case 4:
    return c.runs_bytes;
  case 5:
    return c.offset;
  case 6:
    return c.runs_decoded;
  case 7:
    return c.kept;
  case 8:
    return c.holes;
  case 9:
    return c.min_code;
  case 10:
    return c.max_code;
  case 11:
    return c.crc;
  case 12:
    return c.coding;
  default:
    return c.predictor;
  }
}

void set_column(Bcc4Chunk& c, uint8_t id, uint64_t value) {
  const auto v = static_cast<uint32_t>(value);
  switch (id) {
  case 1:
    c.slab = v;
    break;
  case 2:
    c.slot = v;
    break;
  case 3:
    c.values_bytes = v;
    break;
  case 4:
    c.runs_bytes = v;
    break;
  case 5:
    c.offset = value;
    break;
  case 6:
    c.runs_decoded = v;
    break;
  case 7:
    c.kept = v;
    break;
  case 8:
    c.holes = v;
    break;
  case 9:
    c.min_code = v;
    break;
  case 10:
    c.max_code = v;
    break;
  case 11:
    c.crc = v;
    break;
  case 12:
    c.coding = static_cast<uint8_t>(v);
    break;
  default:
    c.predictor = static_cast<uint8_t>(v);
    break;
  }
}

// Entries of some columns are stored as differences: slabs and slots to those of the entry before, offsets to
// where that one ends.
[[nodiscard]] uint64_t column_base(const Bcc4Chunk& before, uint8_t id) {
  if (id == 1 || id == 2) return get_column(before, id);
  return id == 5 ? before.offset + before.stored() : 0;
}

void check_chunk(const Bcc4Chunk& c, const StoredLattice& info, const Int3& slots, const SampleCoder& coder,
                 uint64_t file_bytes) {
  const auto bad = [&](const auto&... why) {
    fail(Code::corrupt, "index entry of the chunk at offset ", c.offset, " (slab ", c.slab, ", brick ",
         c.slot, "): ", why...);
  };
  if (c.offset < preamble_bytes || c.offset % 8 != 0 || c.offset > file_bytes ||
      c.stored() > file_bytes - c.offset)
    bad(c.stored(), " bytes do not lie in the file of ", file_bytes, " bytes");
  const uint64_t sites = tile_place(info, c.slab, slot_brick(slots, c.slot, info.tile_edge)).sites();
  if (c.kept == 0 || c.kept > sites) bad(c.kept, " kept sites of ", sites);
  if (c.holes > c.kept) bad(c.holes, " holes in ", c.kept, " kept sites");
  const int values = c.coding & 15, runs = c.coding >> 4;
  const bool wavelets = info.tile_edge > 1;
  if (runs > 1 || (wavelets ? values != wavelet_part : values > 1)) bad("unknown coding ", c.coding);
  if (c.predictor >= predictor_count || (values != deflated_part && c.predictor != 0))
    bad("unknown predictor ", static_cast<int>(c.predictor));
  const uint64_t raw_values = uint64_t{c.kept} * coder.codes().bytes();
  if (!wavelets && (values == 0 ? c.values_bytes != raw_values : !can_inflate(c.values_bytes, raw_values)))
    bad(c.values_bytes, " bytes of values for ", c.kept, " sites");
  if (c.runs_decoded > most_run_bytes(sites, c.kept, c.holes))
    bad("run lists of ", c.runs_decoded, " bytes for ", sites, " sites");
  if (runs == 0 ? c.runs_bytes != c.runs_decoded : !can_inflate(c.runs_bytes, c.runs_decoded))
    bad(c.runs_bytes, " bytes of runs for ", c.runs_decoded);
  if (c.min_code > c.max_code || c.min_code < coder.lowest() || c.max_code > coder.highest())
    bad("samples from code ", c.min_code, " to ", c.max_code);
}

} // namespace

Int3 slot_dims(const StoredLattice& info) {
  Int3 n = info.lattice.space.dims(0);
  const int32_t edge = brick_edge * info.tile_edge;
  for (int32_t& v : n) v = (v + edge - 1) / edge;
  return n;
}

uint64_t slot_count(const StoredLattice& info) {
  const Int3 n = slot_dims(info);
  return static_cast<uint64_t>(n[0]) * n[1] * n[2];
}

uint64_t brick_count(const Lattice4& lattice) { return slot_count(StoredLattice{lattice}); }

std::vector<std::byte> write_page(std::span<const Bcc4Chunk> chunks) {
  ByteWriter out;
  out.write(static_cast<uint32_t>(chunks.size()));
  out.write(static_cast<uint32_t>(columns.size()));
  for (const auto& [id, width] : columns) {
    out.write(id);
    out.write(width);
    out.write(uint16_t{0});
  }
  for (const auto& [id, width] : columns)
    for (uint8_t byte = 0; byte < width; ++byte) {
      Bcc4Chunk before{};
      for (const Bcc4Chunk& c : chunks) {
        out.write(static_cast<uint8_t>((get_column(c, id) - column_base(before, id)) >> (8 * byte)));
        before = c;
      }
    }
  return out.release();
}

PageRef describe_page(const ChannelLevel& at, std::span<const Bcc4Chunk> chunks) {
  PageRef ref;
  ref.channel = at.channel, ref.level = at.level;
  ref.first_slab = chunks.front().slab, ref.first_slot = chunks.front().slot;
  ref.last_slab = chunks.back().slab, ref.last_slot = chunks.back().slot;
  ref.entries = static_cast<uint32_t>(chunks.size());
  ref.min_code = UINT32_MAX;
  for (const Bcc4Chunk& c : chunks) {
    ref.min_code = std::min(ref.min_code, c.min_code);
    ref.max_code = std::max(ref.max_code, c.max_code);
  }
  return ref;
}

std::vector<Bcc4Chunk> read_page(std::span<const std::byte> decoded, const PageRef& ref,
                                 const VolumeInfo& info, uint64_t file_bytes) {
  ByteReader in(decoded, "index page");
  const auto bad = [&](const auto&... why) {
    fail(Code::corrupt, "index page at offset ", ref.block.offset, ": ", why...);
  };
  const auto entries = in.read<uint32_t>();
  if (entries != ref.entries) bad(entries, " entries, the directory says ", ref.entries);
  const auto column_count = in.read<uint32_t>();
  if (column_count > 256) bad(column_count, " columns");
  std::vector<Column> present(column_count);
  for (Column& c : present) {
    c.id = in.read<uint8_t>();
    c.width = in.read<uint8_t>();
    if (in.read<uint16_t>() != 0) bad("reserved bytes of column ", c.id, " are not zero");
  }
  std::vector<Bcc4Chunk> chunks(entries);
  size_t known = 0;
  for (const auto& [id, width] : present) {
    const auto bytes = in.take(uint64_t{entries} * width);
    if (id >= 128) continue;
    if (known == columns.size() || columns[known].id != id || columns[known].width != width)
      fail(Code::unsupported_version, "index page at offset ", ref.block.offset, ": column ", id, " of ",
           width, " bytes is out of place or unknown; update bccsplat");
    ++known;
    const uint64_t wrap = width == 8 ? UINT64_MAX : (uint64_t{1} << (8 * width)) - 1;
    Bcc4Chunk before{};
    for (uint32_t i = 0; i < entries; ++i) {
      uint64_t value = 0;
      for (uint8_t b = 0; b < width; ++b)
        value |= static_cast<uint64_t>(bytes[size_t{b} * entries + i]) << (8 * b);
      set_column(chunks[i], id, (column_base(before, id) + value) & wrap);
      before = chunks[i];
    }
  }
  if (known != columns.size()) bad("columns are missing");
  in.expect_end();

  const SampleCoder coder(info.channels.at(ref.at().channel));
  const StoredLattice& level = info.level(ref.at().level);
  const Int3 slots = slot_dims(level);
  const uint64_t count = slot_count(level);
  const Bcc4Chunk* before = nullptr;
  PageRef found;
  found.min_code = UINT32_MAX;
  for (const Bcc4Chunk& c : chunks) {
    if (c.slab < 0 || c.slab >= level.slabs() || c.slot >= count)
      bad("slab ", c.slab, ", brick ", c.slot, " do not exist");
    if (before && std::tie(before->slab, before->slot) >= std::tie(c.slab, c.slot))
      bad("entries do not rise at slab ", c.slab, ", brick ", c.slot);
    check_chunk(c, level, slots, coder, file_bytes);
    found.min_code = std::min(found.min_code, c.min_code);
    found.max_code = std::max(found.max_code, c.max_code);
    before = &c;
  }
  if (chunks.front().slab != ref.first_slab || chunks.front().slot != ref.first_slot ||
      chunks.back().slab != ref.last_slab || chunks.back().slot != ref.last_slot)
    bad("first or last entry differs from the directory");
  if (found.min_code != ref.min_code || found.max_code != ref.max_code)
    bad("smallest or largest sample differs from the directory");
  return chunks;
}

std::vector<std::byte> write_directory(std::span<const PageRef> pages) {
  ByteWriter out;
  for (const PageRef& p : pages) {
    out.write(p.channel);
    out.write(p.first_slab);
    out.write(p.first_slot);
    out.write(p.last_slab);
    out.write(p.last_slot);
    out.write(p.entries);
    write_block_ref(out, p.block);
    out.write(p.min_code);
    out.write(p.max_code);
    out.write(p.level);
    out.write(uint32_t{0});
  }
  return out.release();
}

std::vector<PageRef> read_directory(std::span<const std::byte> decoded, const VolumeInfo& info,
                                    const Root& root, uint64_t offset) {
  const auto bad = [&](const auto&... why) {
    fail(Code::corrupt, "index directory at offset ", offset, ": ", why...);
  };
  if (decoded.size() % page_ref_bytes != 0) bad(decoded.size(), " bytes are no whole number of records");
  ByteReader in(decoded, "index directory", offset);
  std::vector<PageRef> pages(decoded.size() / page_ref_bytes);
  uint64_t chunks = 0;
  const PageRef* before = nullptr;
  for (PageRef& p : pages) {
    p.channel = in.read<uint32_t>();
    p.first_slab = in.read<int32_t>();
    p.first_slot = in.read<uint32_t>();
    p.last_slab = in.read<int32_t>();
    p.last_slot = in.read<uint32_t>();
    p.entries = in.read<uint32_t>();
    p.block = read_block_ref(in);
    p.min_code = in.read<uint32_t>();
    p.max_code = in.read<uint32_t>();
    p.level = in.read<uint32_t>();
    if (in.read<uint32_t>() != 0) bad("reserved bytes are not zero");
    if (p.channel >= info.channels.size()) bad("channel ", p.channel, " of ", info.channels.size());
    if (p.level > info.levels.size()) bad("level ", p.level, " of ", info.level_count());
    const StoredLattice& level = info.level(p.at().level);
    const uint64_t slots = slot_count(level);
    if (p.entries == 0 || p.entries > max_page_entries) bad("a page of ", p.entries, " entries");
    if (p.first_slab < 0 || p.last_slab >= level.slabs() || p.first_slot >= slots || p.last_slot >= slots ||
        std::tie(p.first_slab, p.first_slot) > std::tie(p.last_slab, p.last_slot))
      bad("a page from slab ", p.first_slab, ", brick ", p.first_slot, " to slab ", p.last_slab, ", brick ",
          p.last_slot);
    if (before && std::tie(before->channel, before->level, before->last_slab, before->last_slot) >=
                      std::tie(p.channel, p.level, p.first_slab, p.first_slot))
      bad("pages do not rise at channel ", p.channel, ", level ", p.level, ", slab ", p.first_slab,
          ", brick ", p.first_slot);
    check_block_ref(p.block, "index page", root.file_bytes);
    if (p.block.decoded > max_page_bytes) bad("a page of ", p.block.decoded, " bytes");
    chunks += p.entries;
    before = &p;
  }
  if (chunks != root.chunks) bad(chunks, " chunks, the root says ", root.chunks);
  return pages;
}

} // namespace bccsplat
