// SPDX-License-Identifier: Apache-2.0
// Writes and reads the header, the root records and the blocks of a file.
#include "formats/bcc4/layout.h"

#include <algorithm>
#include <cstring>

#include "base/sizes.h"
#include "formats/bcc4/coding/deflate.h"
#include "formats/bcc4/counts.h"

namespace bccsplat {
namespace {

// A mark like that of PNG: a 7-bit transfer clears the high bit, text mode changes the line ends, 0x1a ends
// DOS listings and the zero ends C strings.
constexpr std::array<uint8_t, 12> magic{0x89, 'B', 'C', 'C', '4', 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0xff, 0xfe};
constexpr std::array<char, 8> root_magic{'B', 'C', 'C', '4', 'R', 'O', 'O', 'T'};

[[nodiscard]] bool all_zero(std::span<const std::byte> bytes) {
  return std::all_of(bytes.begin(), bytes.end(), [](std::byte b) { return b == std::byte{0}; });
}

// Reads a root record; throws when it fails a check.
[[nodiscard]] Root read_root(std::span<const std::byte> bytes, uint64_t offset) {
  if (crc32_of(bytes.first(root_bytes - 4)) !=
      ByteReader(bytes.subspan(root_bytes - 4), "root").read<uint32_t>())
    fail(Code::checksum_mismatch, "root record at offset ", offset, ": bad checksum");
  if (std::memcmp(bytes.data(), root_magic.data(), root_magic.size()) != 0)
    fail(Code::corrupt, "root record at offset ", offset, ": wrong mark");
  ByteReader in(bytes, "root record", offset);
  static_cast<void>(in.take(root_magic.size()));
  Root root;
  root.sequence = in.read<uint64_t>();
  root.file_bytes = in.read<uint64_t>();
  root.metadata = read_block_ref(in);
  root.directory = read_block_ref(in);
  root.chunks = in.read<uint64_t>();
  root.runs_bytes = in.read<uint64_t>();
  root.values_bytes = in.read<uint64_t>();
  root.index_bytes = in.read<uint64_t>();
  const auto state = in.read<uint32_t>();
  root.unfinished = state == 1, root.frames = in.read<uint32_t>();
  if (state > 1) fail(Code::corrupt, "root record at offset ", offset, ": unknown state ", state);
  if (root.unfinished != (root.frames > 0))
    fail(Code::corrupt, "root record at offset ", offset, ": ", root.frames, " frames of ",
         root.unfinished ? "an unfinished" : "a finished", " series can be looked at");
  if (!all_zero(in.take(in.remaining() - 4)))
    fail(Code::corrupt, "root record at offset ", offset, ": reserved bytes are not zero");
  if (root.sequence == 0) fail(Code::corrupt, "root record at offset ", offset, ": sequence number 0");
  if (root.file_bytes < preamble_bytes || root.file_bytes > INT64_MAX)
    fail(Code::corrupt, "root record at offset ", offset, ": a file of ", root.file_bytes, " bytes");
  check_block_ref(root.metadata, "metadata", root.file_bytes);
  check_block_ref(root.directory, "index directory", root.file_bytes);
  if (checked_add(checked_add(root.runs_bytes, root.values_bytes), root.index_bytes) > root.file_bytes)
    fail(Code::corrupt, "root record at offset ", offset, ": parts are larger than the file");
  return root;
}

void read_header(std::span<const std::byte> bytes, std::string_view file) {
  ByteReader header(bytes, "header");
  static_cast<void>(header.take(magic.size()));
  static_cast<void>(header.read<uint16_t>());
  const auto lowest_reader = header.read<uint16_t>();
  const auto reserved = header.take(header.remaining() - 4);
  if (header.read<uint32_t>() != crc32_of(bytes.first(header_bytes - 4)))
    fail(Code::checksum_mismatch, file, ": header at offset 0: bad checksum");
  if (lowest_reader < bcc4_version)
    fail(Code::unsupported_version, file,
         ": made by a build before 0.1.0, whose files no later one reads; import its source again");
  if (lowest_reader > bcc4_version)
    fail(Code::unsupported_version, file, ": needs a reader of version ", lowest_reader, ", this one is ",
         bcc4_version, "; update bccsplat");
  if (!all_zero(reserved)) fail(Code::corrupt, file, ": header at offset 0: reserved bytes are not zero");
}

[[noreturn]] void fail_magic(std::span<const std::byte> bytes, std::string_view file) {
  const auto at = [&](size_t i) { return i < bytes.size() ? static_cast<uint8_t>(bytes[i]) : uint8_t{0}; };
  if ((at(0) & 0x7f) == (magic[0] & 0x7f) && at(1) == 'B' && at(2) == 'C' && at(3) == 'C' && at(4) == '4')
    fail(bytes.size() < magic.size() ? Code::truncated : Code::corrupt, file,
         bytes.size() < magic.size() ? ": cut short, " : ": damaged by a transfer as text, ",
         "copy it again in binary mode");
  if (bytes.size() >= header_bytes && all_zero(bytes))
    fail(Code::not_bcc4, file, ": not a .bcc4 file, or one that was never finished: it starts with zeros");
  fail(Code::not_bcc4, file, ": not a .bcc4 file");
}

} // namespace

void write_block_ref(ByteWriter& out, const BlockRef& ref) {
  out.write(ref.offset);
  out.write(ref.stored);
  out.write(ref.decoded);
  out.write(ref.crc);
  out.write(ref.coding);
}

BlockRef read_block_ref(ByteReader& in) {
  BlockRef ref;
  ref.offset = in.read<uint64_t>();
  ref.stored = in.read<uint32_t>();
  ref.decoded = in.read<uint32_t>();
  ref.crc = in.read<uint32_t>();
  ref.coding = in.read<uint32_t>();
  return ref;
}

void check_block_ref(const BlockRef& ref, std::string_view what, uint64_t file_bytes) {
  if (ref.offset < preamble_bytes || ref.offset % 8 != 0 || ref.offset > file_bytes ||
      ref.padded() > file_bytes - ref.offset)
    fail(Code::corrupt, what, ": ", ref.stored, " bytes at offset ", ref.offset,
         " do not lie in the file of ", file_bytes, " bytes");
  if (ref.coding > 1) fail(Code::corrupt, what, " at offset ", ref.offset, ": unknown coding ", ref.coding);
  if (ref.coding == 0 ? ref.stored != ref.decoded : !can_inflate(ref.stored, ref.decoded))
    fail(Code::corrupt, what, " at offset ", ref.offset, ": ", ref.stored, " bytes cannot stand for ",
         ref.decoded);
}

PackedBlock pack_block(std::span<const std::byte> decoded, Progress* progress) {
  if (decoded.size() > UINT32_MAX / 2) fail(Code::limit_exceeded, "a block of ", decoded.size(), " bytes");
  PackedBlock block;
  block.bytes = deflate_bytes(decoded, 9, DeflateKind::text, progress);
  auto other = deflate_bytes(decoded, 9, DeflateKind::noise, progress);
  if (other.size() < block.bytes.size()) block.bytes = std::move(other);
  block.ref.coding = 1;
  if (block.bytes.size() >= decoded.size()) {
    block.bytes.assign(decoded.begin(), decoded.end());
    block.ref.coding = 0;
  }
  block.ref.stored = static_cast<uint32_t>(block.bytes.size());
  block.ref.decoded = static_cast<uint32_t>(decoded.size());
  block.bytes.resize(block.ref.padded());
  block.ref.crc = crc32_of(block.bytes);
  return block;
}

std::vector<std::byte> unpack_block(const BlockRef& ref, std::span<const std::byte> bytes,
                                    std::string_view what) {
  if (crc32_of(bytes) != ref.crc)
    fail(Code::checksum_mismatch, what, " at offset ", ref.offset, ": bad checksum");
  if (!all_zero(bytes.subspan(ref.stored)))
    fail(Code::corrupt, what, " at offset ", ref.offset, ": padding is not zero");
  if (ref.coding == 0) return {bytes.begin(), bytes.begin() + ref.stored};
  std::vector<std::byte> decoded(ref.decoded);
  if (!inflate_bytes(bytes.first(ref.stored), decoded))
    fail(Code::corrupt, what, " at offset ", ref.offset, ": no deflate stream of ", ref.decoded, " bytes");
  return decoded;
}

std::vector<std::byte> write_root(const Root& root) {
  ByteWriter record;
  record.write_bytes(std::as_bytes(std::span(root_magic)));
  record.write(root.sequence);
  record.write(root.file_bytes);
  write_block_ref(record, root.metadata);
  write_block_ref(record, root.directory);
  record.write(root.chunks);
  record.write(root.runs_bytes);
  record.write(root.values_bytes);
  record.write(root.index_bytes);
  record.write(uint32_t{root.unfinished});
  record.write(root.frames);
  while (record.size() < root_bytes - 4) record.write(uint8_t{0});
  record.write(crc32_of(record.bytes()));
  return record.release();
}

std::vector<std::byte> write_preamble(const Root& root) {
  ByteWriter out;
  out.write_bytes(std::as_bytes(std::span(magic)));
  out.write(bcc4_version); // whose rules the file keeps
  out.write(bcc4_version); // that a reader needs
  while (out.size() < header_bytes - 4) out.write(uint8_t{0});
  out.write(crc32_of(out.bytes()));
  out.write_bytes(write_root(root));
  return out.release();
}

Preamble read_preamble(std::span<const std::byte> bytes, std::string_view file) {
  if (bytes.size() < magic.size() || std::memcmp(bytes.data(), magic.data(), magic.size()) != 0)
    fail_magic(bytes, file);
  if (bytes.size() < preamble_bytes)
    fail(Code::truncated, file, ": ", bytes.size(), " bytes, a .bcc4 file has at least ", preamble_bytes);
  read_header(bytes.first(header_bytes), file);
  Preamble preamble;
  try {
    preamble.root = read_root(bytes.subspan(root_offset, root_bytes), root_offset);
  } catch (const Error& e) {
    preamble.problem = e.message();
  }
  return preamble;
}

std::optional<Root> read_root_copy(std::span<const std::byte> last, uint64_t file_bytes) {
  if (last.size() < root_bytes || file_bytes < preamble_bytes + root_bytes) return std::nullopt;
  try {
    const Root root = read_root(last.last(root_bytes), file_bytes - root_bytes);
    if (root.file_bytes == file_bytes) return root;
  } catch (const Error&) { // bytes of anything
  }
  return std::nullopt;
}

} // namespace bccsplat
