// SPDX-License-Identifier: Apache-2.0
// What an open file holds; reading and verifying share it.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "base/damage.h"
#include "base/lru_cache.h"
#include "formats/bcc4/coding/chunk.h"
#include "formats/bcc4/coding/codes.h"
#include "formats/bcc4/coding/scratch.h"
#include "formats/bcc4/field_base.h"
#include "formats/bcc4/file_limits.h"
#include "formats/bcc4/layout.h"
#include "formats/bcc4/page.h"
#include "formats/bcc4/read/reader.h"

namespace bccsplat {

using Page = std::vector<Bcc4Chunk>;

struct Bcc4Reader::State {
  struct Verification; // verify.cpp

  State(std::unique_ptr<ByteSource> s, const Bcc4Limits& l)
      : source(std::move(s)), limits(l), cached(l.cached_pages) {}

  std::unique_ptr<ByteSource> source;
  Bcc4Limits limits;
  Root root;
  bool root_damaged = false;       // and a copy is read
  VolumeInfo info;                 // as the file has it
  std::optional<VolumeInfo> shown; // of an unfinished series: of the frames that can be looked at
  Bcc4Bytes bytes;
  std::vector<Int3> slots;            // by level: brick dims of coset 0
  std::vector<SampleCoder> coders;    // by channel, relative to air
  std::vector<SampleCoder> from_base; // relative to the base of the field
  std::vector<FieldBase> bases;       // by channel
  std::vector<PageRef> pages;         // the directory
  mutable LruCache<size_t, Page> cached;
  mutable std::atomic<uint64_t> bytes_read{0};

  void open();
  void read_head();
  void check_root() const;
  void read_description();
  void prepare_coders();
  [[nodiscard]] VolumeInfo shown_part() const;
  // Throws unless there are such a channel and level.
  void require(const ChannelLevel& at) const;
  [[nodiscard]] const SampleCoder& coder(const ChannelLevel& at, RelativeTo to = RelativeTo::air) const {
    return (to == RelativeTo::base ? from_base : coders).at(at.channel);
  }
  [[nodiscard]] Int3 brick_of(uint32_t slot, int level) const {
    return slot_brick(slots.at(level), slot, info.tile_edge);
  }
  [[nodiscard]] ChunkShape shape_of(const Bcc4Chunk& chunk, int level) const {
    return chunk_shape(info.level(level), chunk.slab, brick_of(chunk.slot, level));
  }
  [[nodiscard]] TilePlace tile_of(const Bcc4Chunk& chunk, int level) const {
    return tile_place(info.level(level), chunk.slab, brick_of(chunk.slot, level));
  }
  [[nodiscard]] bool goes_without(const Error& failure) const {
    return limits.salvage &&
           (is_damage(failure.code()) || (limits.salvage_unreadable && is_unreadable(failure.code())));
  }
  // Runs a step; errors about the bytes of the file name it.
  template<class Step> auto in_file(const Step& step) const -> decltype(step()) {
    try {
      return step();
    } catch (const Error& e) {
      if (!is_damage(e.code()) || e.message().starts_with(source->name())) throw;
      throw Error(e.code(), concat(source->name(), ": ", e.message()));
    }
  }
  // Reads from the source and counts the bytes.
  void read(uint64_t offset, std::span<std::byte> out) const;
  // The same; returns false for bytes that a salvaged file goes without.
  [[nodiscard]] bool read_or_lose(uint64_t offset, std::span<std::byte> out) const;
  [[nodiscard]] std::vector<std::byte> read_block(const BlockRef& ref, std::string_view what) const;
  // These are the reader's calls of the same names, but refuse damage also when salvaging.
  [[nodiscard]] FrameResiduals residuals(int channel, uint64_t frame) const;
  [[nodiscard]] std::vector<CorrectionBrick> correction_bricks(int channel, uint64_t frame) const;
  [[nodiscard]] ResidualList corrections(int channel, const CorrectionBrick& brick) const;
  // Returns where the pages of a slab begin and end in the directory.
  [[nodiscard]] std::pair<size_t, size_t> pages_of(const ChannelLevel& at, int32_t slab) const;
  [[nodiscard]] std::shared_ptr<const Page> load_page(size_t index) const; // not cached
  [[nodiscard]] std::shared_ptr<const Page> page(size_t index) const;
  // The chunks that a damaged page may have listed; a chunk that is lost has kept == 0.
  [[nodiscard]] Page lost_page(const PageRef& ref) const;
  // A chunk whose sites are all holes, for one that is lost.
  [[nodiscard]] ChunkData lost_chunk(const ChannelLevel& at, const Bcc4Chunk& chunk) const;
  [[nodiscard]] ChunkData decode_or_lose(const ChannelLevel& at, const Bcc4Chunk& chunk,
                                         std::span<const std::byte> stored, ChunkScratch& scratch,
                                         int layers) const;
  // Decodes a chunk; a tile only down to what its bricks are made of.
  [[nodiscard]] ChunkData decode(const ChannelLevel& at, const Bcc4Chunk& chunk,
                                 std::span<const std::byte> stored, ChunkScratch& scratch,
                                 int layers = max_slab_layers) const;
};

// Chunks that are read together, as indices into a list, in the order of the file.
struct ChunkGroup {
  uint64_t offset = 0, bytes = 0;
  std::vector<size_t> members;
};
// gap: unwanted bytes between two chunks that are read along.
[[nodiscard]] std::vector<ChunkGroup> group_chunks(std::span<const Bcc4Chunk> chunks, uint64_t gap);

} // namespace bccsplat
