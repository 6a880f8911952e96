// SPDX-License-Identifier: Apache-2.0
// What a writer holds, and its steps: slabs (writer_slabs.cpp) and what makes a file of them
// (writer_roots.cpp). The order of calls is checked in writer.cpp.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "formats/bcc4/coding/chunk.h"
#include "formats/bcc4/layout.h"
#include "formats/bcc4/page.h"
#include "formats/bcc4/read/reader.h"
#include "formats/bcc4/write/append_sink.h"
#include "formats/bcc4/write/frame_blocks.h"
#include "formats/bcc4/write/journal.h"
#include "formats/bcc4/write/writer.h"
#include "formats/bcc4/write/writer_index.h"

namespace bccsplat {

struct Bcc4Writer::State {
  State(std::unique_ptr<ByteSink> sink, const VolumeInfo& initial, const Bcc4WriterOptions& o);

  AppendSink file;
  Bcc4WriterOptions options;
  VolumeInfo info, fixed;            // fixed: as it was when the first samples came
  uint64_t unused;                   // bytes before the first chunk that are no preamble
  std::optional<WriterIndex> index;  // from the first samples on
  std::optional<FrameBlocks> frames; // likewise
  uint64_t slabs_reused = 0;
  struct Shown {
    uint64_t times = 0;    // roots written so far
    uint64_t replaced = 0; // bytes of tables that were shown before the last time, and of copies of roots
    uint64_t bytes = 0;    // of those of the last time
  } shown;
  bool closed = false; // finished, or failed half way

  // Refuses to go on behind the end or a failure. The first data fix what may not change any more.
  void begin();
  // Takes a step as a whole: where it fails nothing may follow.
  template<class Step> void whole(const Step& step) {
    closed = true;
    step();
    closed = false;
  }
  void check_layers(int32_t slab, const ChannelLevel& at, std::span<const SampleLayer> layers) const;
  void check_channel(int channel) const;
  void add_mask(int channel, uint32_t frame, PackedBlock block, uint64_t missing);

  // Codes a slab, or takes over what an earlier writer or file has of it.
  void write_slab(int32_t slab, const ChannelLevel& at, std::span<const SampleLayer> layers, double rounded,
                  const Context& context);
  WrittenSlab copy_chunks(int32_t slab, const ChannelLevel& at, std::span<const Bcc4Reader* const> from);
  // Leaves a journal of all that was coded when the writer is let go before it has finished. Where that
  // fails, some of it will be coded again.
  void keep() noexcept;

  void show(VolumeInfo of, const Context& context);
  [[nodiscard]] Bcc4Report finish(const Context& context);

  [[nodiscard]] std::vector<SampleLayer> as_read(int32_t slab, const ChannelLevel& at,
                                                 std::span<const SampleLayer> layers, double rounded,
                                                 const Context& context);

 private:
  void start();
  [[nodiscard]] WrittenSlab encode_slab(int32_t slab, const ChannelLevel& at,
                                        std::span<const SampleLayer> layers, const Context& context);
  // The coded tiles of a slab, by rising slot.
  struct CodedTiles {
    int32_t slab = -1;
    ChannelLevel at{0};
    std::vector<EncodedChunk> chunks;
    std::vector<SampleLayer> read; // what a reader gets, until somebody has taken it
    uint64_t clamped = 0;
  };
  [[nodiscard]] CodedTiles code_tiles(int32_t slab, const ChannelLevel& at,
                                      std::span<const SampleLayer> layers, double rounded,
                                      const Context& context) const;
  [[nodiscard]] WrittenSlab encode_tiles(int32_t slab, const ChannelLevel& at,
                                         std::span<const SampleLayer> layers, double rounded,
                                         const Context& context);
  // Puts a chunk behind what is written; its slot is known.
  void append_chunk(const ChannelLevel& at, const EncodedChunk& chunk, WrittenSlab& written);
  // What an earlier writer has left of a slab; null: nothing. Whether an earlier file has it.
  [[nodiscard]] const WrittenSlab* in_journal(int32_t slab, const ChannelLevel& at, int32_t layers) const;
  [[nodiscard]] bool in_earlier(int32_t slab, const ChannelLevel& at, int32_t layers) const;
  // What a reader gets of such a slab; empty where it is to be coded.
  [[nodiscard]] std::vector<SampleLayer> read_reused(int32_t slab, const ChannelLevel& at, int32_t layers,
                                                     const Context& context) const;
  [[nodiscard]] std::optional<WrittenSlab> reuse_slab(int32_t slab, const ChannelLevel& at, int32_t layers);
  void skip_chunks(const WrittenSlab& slab);
  void commit_pending();
  // Appends directory and metadata. beyond: bytes of blocks that the state does not refer to.
  [[nodiscard]] Root append_state(const VolumeInfo& of, std::span<const PageRef> pages, uint64_t beyond);
  // Makes all that is written durable, then writes the head of the file; where there is one already, a copy
  // of the new root goes behind the state first. What an earlier writer showed stays until there is as much
  // again, in the same bytes.
  void write_head(Root root);

  CodedTiles last_tiles; // of the slab that was coded last
};

} // namespace bccsplat
