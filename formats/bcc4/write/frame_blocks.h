// SPDX-License-Identifier: Apache-2.0
// What a file that is being written has beside chunks: corrections and masks of source frames, each frame in
// blocks of its own.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "formats/bcc4/read/reader.h"
#include "formats/bcc4/write/append_sink.h"
#include "formats/bcc4/write/mask_blocks.h"

namespace bccsplat {

class FrameBlocks {
 public:
  // file: outlives this.
  FrameBlocks(AppendSink& file, size_t channels) : file_(file), channels_(channels) {}

  [[nodiscard]] size_t channels() const { return channels_.size(); }
  // Writes the corrections of a frame. Those to add go into bricks where the channel's are local.
  void write_corrections(const VolumeInfo& info, int channel, uint32_t frame, const FrameResiduals& residuals,
                         const Context& context);
  // Copies the corrections of a frame from files that have those of some of its samples each. Bricks of one
  // file alone are not decoded. Throws invalid_argument where two correct the same sample, unsupported where
  // two have corrections in holes of the lattice.
  void copy_corrections(const VolumeInfo& info, int channel, uint32_t frame,
                        std::span<const Bcc4Reader* const> from, const Context& context);
  // Writes a mask, or refers to one that says the same. missing: how many samples it says are.
  void add_mask(int channel, uint32_t frame, PackedBlock block, uint64_t missing);

  // Lists the blocks of the frames that the info has, and the sums of what they hold.
  void describe(VolumeInfo& to) const;
  // Bytes of masks that only frames from `frames` on have.
  [[nodiscard]] uint64_t masks_beyond(uint32_t frames) const;
  [[nodiscard]] uint64_t correction_bytes() const { return correction_bytes_; }

 private:
  // The blocks of a channel, by frame.
  struct Channel {
    std::vector<BlockRef> residuals, tables; // of corrections
    std::vector<BlockRef> masks;
    std::vector<FrameSums> sums; // of each frame alone
    [[nodiscard]] FrameSums& sums_of(uint32_t frame) {
      if (sums.size() <= frame) sums.resize(size_t{frame} + 1);
      return sums[frame];
    }
  };
  [[nodiscard]] Channel& at(int channel) { return channels_[channel]; }
  void write_bricks(const VolumeInfo& info, int channel, uint32_t frame, std::span<const ResidualSample> list,
                    const Context& context);
  [[nodiscard]] BlockRef append_corrections(const PackedBlock& block);
  void copy_whole(int channel, uint32_t frame, std::span<const Bcc4Reader* const> from);
  void append_table(int channel, uint32_t frame, std::span<const CorrectionBrick> table);

  AppendSink& file_;
  std::vector<Channel> channels_;
  MaskBlocks masks_;
  uint64_t correction_bytes_ = 0;
};

} // namespace bccsplat
