// SPDX-License-Identifier: Apache-2.0
// The index of a file that is being written: the chunks of every channel and level in pages, and their sums.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "formats/bcc4/coding/codes.h"
#include "formats/bcc4/page.h"
#include "formats/bcc4/write/writer.h"

namespace bccsplat {

class WriterIndex {
 public:
  // Puts a decoded block into the file.
  using AppendBlock = std::function<BlockRef(std::span<const std::byte>)>;
  // info: says how channels are coded, at every level.
  WriterIndex(const VolumeInfo& info, AppendBlock append);

  [[nodiscard]] const SampleCoder& coder(const ChannelLevel& at) const { return stream(at).coder; }
  // Fails unless the slab may be the next one of its channel and level: they rise, and of a periodic series
  // the first ones may come behind the last one.
  void check_slab(int32_t slab, const ChannelLevel& at, const VolumeInfo& info) const;
  // Lists a chunk whose bytes are in their place; writes its page when that is full.
  void enter_chunk(const ChannelLevel& at, const Bcc4Chunk& entry);
  void enter_slab(int32_t slab, const ChannelLevel& at, int32_t layers, uint64_t clamped);
  // Fails where the last slab of a channel is not that of its lattice.
  void check_ends(const VolumeInfo& info) const;
  // Writes what is left of the pages; returns all of them, as the directory lists them.
  [[nodiscard]] std::vector<PageRef> finish_pages();
  // The same while chunks are still to come. Pages that are not full are merged as they come to be of equal
  // size: there are few of them, and what they leave behind is at most a few times what they hold.
  [[nodiscard]] std::vector<PageRef> show_pages();
  // Bytes of pages that were shown, and that later ones have replaced.
  [[nodiscard]] uint64_t replaced_bytes() const { return replaced_bytes_; }
  // Slabs that every channel has at every level; 0 where some have more than others, or an unfull last one.
  [[nodiscard]] int32_t common_slabs(const VolumeInfo& info) const;
  // Adds what was counted to `info`, and to `report` what level 0 counted.
  void describe(VolumeInfo& info, Bcc4Report& report) const;

  [[nodiscard]] uint64_t chunks() const { return chunks_; }
  [[nodiscard]] uint64_t runs_bytes() const { return runs_bytes_; }
  [[nodiscard]] uint64_t values_bytes() const { return values_bytes_; }

 private:
  // One channel at one level.
  struct Stream {
    Stream(const ChannelLevel& which, const Quantiser& coding) : at(which), coder(coding) {}
    ChannelLevel at;
    SampleCoder coder;
    std::vector<Bcc4Chunk> pending; // entries of no page yet
    std::vector<PageRef> pages;
    std::vector<PageRef> shown; // of the first of `pending`, ever smaller ones
    int32_t first_slab = -1;    // the one that came first
    int32_t last_slab = -1, last_slab_layers = 0;
    int32_t end_slab = -1, end_slab_layers = 0; // the one that stands last
    bool turned = false;                        // slabs before the first one have begun
    size_t turned_pages = 0;                    // pages of the slabs that came before these
    uint64_t kept = 0, holes = 0, clamped = 0;
    uint32_t min_code = UINT32_MAX, max_code = 0;
  };
  [[nodiscard]] size_t place_of(const ChannelLevel& at) const { return at.channel * levels_ + at.level; }
  [[nodiscard]] const Stream& stream(const ChannelLevel& at) const { return streams_.at(place_of(at)); }
  [[nodiscard]] Stream& stream(const ChannelLevel& at) { return streams_.at(place_of(at)); }
  [[nodiscard]] PageRef append_page(const Stream& s, size_t first);
  void drop_shown(Stream& s);
  void turn(Stream& s);
  // Adds to what VolumeInfo says of a channel at a level.
  template<class Counts> static void add_counts(const Stream& s, Counts& out);

  AppendBlock append_;
  int levels_;
  std::vector<Stream> streams_; // by channel, then level
  uint64_t chunks_ = 0, runs_bytes_ = 0, values_bytes_ = 0, replaced_bytes_ = 0;
};

} // namespace bccsplat
