// SPDX-License-Identifier: Apache-2.0
// The parts of a stored chunk that are alike for all ways to code its values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "formats/bcc4/coding/chunk.h"
#include "formats/bcc4/coding/codes.h"
#include "formats/bcc4/coding/deflate.h"
#include "formats/bcc4/coding/scratch.h"
#include "points/runs.h"

namespace bccsplat {

struct RunsPart {
  std::vector<std::byte> bytes;
  uint32_t decoded = 0;
  uint8_t coding = 0;
};
[[nodiscard]] RunsPart pack_runs(std::vector<std::byte> runs, int level);
// Puts the runs behind the values of a chunk, and says in its entry how long both are, how they are coded,
// and their checksum.
void finish_entry(const RunsPart& runs, uint8_t values_coding, EncodedChunk& chunk);

// Returns a part that is stored raw, or inflates it into `room`, which has `slack` bytes more on both sides.
// `what` and `offset` are told in error texts.
[[nodiscard]] std::span<const std::byte> open_part(std::span<const std::byte> part, uint8_t coding,
                                                   size_t decoded, Inflater& inflater,
                                                   std::vector<std::byte>& room, std::string_view what,
                                                   uint64_t offset, size_t slack = 0);

// Throws where the checksum or the padding is not right.
void check_stored(const Bcc4Chunk& entry, std::span<const std::byte> bytes);
[[nodiscard]] std::span<const std::byte> open_runs(const Bcc4Chunk& entry, std::span<const std::byte> bytes,
                                                   ChunkScratch& scratch);
// Counts the kept sites of each layer.
void find_layers(ChunkData& data);

// The brick of one layer of a chunk; null where all of it is air.
[[nodiscard]] std::shared_ptr<const Brick> brick_of_chunk(const SampleCoder& coder, const ChunkData& data,
                                                          size_t layer);

} // namespace bccsplat
