// SPDX-License-Identifier: Apache-2.0
#include "formats/bcc4/coding/chunk_parts.h"

#include <utility>

#include "base/error.h"
#include "base/page_pool.h"
#include "formats/bcc4/coding/chunk_rows.h"
#include "formats/bcc4/coding/spread.h"

namespace bccsplat {

RunsPart pack_runs(std::vector<std::byte> runs, int level) {
  RunsPart part{{}, static_cast<uint32_t>(runs.size()), raw_part};
  if (level > 0) {
    // Runs of an object repeat from row to row; single sites that are left out here and there do not.
    std::vector<std::byte> stream = deflate_bytes(runs, level, DeflateKind::text);
    std::vector<std::byte> other = deflate_bytes(runs, level, DeflateKind::noise);
    if (other.size() < stream.size()) stream = std::move(other);
    if (stream.size() < runs.size()) runs = std::move(stream), part.coding = deflated_part;
  }
  part.bytes = std::move(runs);
  return part;
}

void finish_entry(const RunsPart& runs, uint8_t values_coding, EncodedChunk& chunk) {
  Bcc4Chunk& entry = chunk.entry;
  entry.runs_decoded = runs.decoded;
  entry.runs_bytes = static_cast<uint32_t>(runs.bytes.size());
  entry.coding = static_cast<uint8_t>(values_coding | runs.coding << 4);
  chunk.bytes.insert(chunk.bytes.end(), runs.bytes.begin(), runs.bytes.end());
  chunk.bytes.resize(entry.stored());
  entry.crc = crc32_of(chunk.bytes);
}

void check_stored(const Bcc4Chunk& entry, std::span<const std::byte> bytes) {
  if (crc32_of(bytes) != entry.crc)
    fail(Code::checksum_mismatch, "chunk at offset ", entry.offset, ": bad checksum");
  for (const std::byte b : bytes.subspan(size_t{entry.values_bytes} + entry.runs_bytes))
    if (b != std::byte{0}) fail(Code::corrupt, "chunk at offset ", entry.offset, ": padding is not zero");
}

std::span<const std::byte> open_part(std::span<const std::byte> part, uint8_t coding, size_t decoded,
                                     Inflater& inflater, std::vector<std::byte>& room, std::string_view what,
                                     uint64_t offset, size_t slack) {
  if (coding == raw_part) {
    if (part.size() != decoded)
      fail(Code::corrupt, what, " at offset ", offset, ": ", part.size(), " raw bytes stand for ", decoded);
    return part;
  }
  if (room.size() < decoded + 2 * slack) room.resize(decoded + 2 * slack);
  const auto inner = std::span(room).subspan(slack, decoded);
  if (!inflater.inflate(part, inner))
    fail(Code::corrupt, what, " at offset ", offset, ": no deflate stream of ", decoded, " bytes");
  return inner;
}

std::span<const std::byte> open_runs(const Bcc4Chunk& entry, std::span<const std::byte> bytes,
                                     ChunkScratch& scratch) {
  return open_part(bytes.subspan(entry.values_bytes, entry.runs_bytes), entry.coding >> 4, entry.runs_decoded,
                   scratch.inflater, scratch.runs, "runs of the chunk", entry.offset + entry.values_bytes);
}

std::shared_ptr<const Brick> brick_of_chunk(const SampleCoder& coder, const ChunkData& data, size_t layer) {
  const uint32_t first = data.first.at(layer);
  if (data.first.at(layer + 1) == first) return nullptr;
  auto brick = make_pooled_for_overwrite<Brick>();
  brick->kept = data.kept[layer];
  if (!data.hole.empty() && data.hole[layer] != BrickMask{})
    brick->hole = std::make_unique<BrickMask>(data.hole[layer]);
  spread_codes(coder, brick->kept, data.codes, first, brick->value);
  return brick;
}

void find_layers(ChunkData& data) {
  uint32_t n = 0;
  data.first.reserve(data.kept.size() + 1);
  for (const BrickMask& mask : data.kept) {
    data.first.push_back(n);
    n += count_bits(mask);
  }
  data.first.push_back(n);
}

} // namespace bccsplat
