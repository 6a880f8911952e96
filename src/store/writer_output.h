// SPDX-License-Identifier: Apache-2.0
// The way from the fits into the file: slabs, masks and corrections as they come, the journal, and what can
// be looked at so far. Holds the container and what waits for it; needs the opening, which says what is
// written, the fits, which know the lattices, and the comparison, which sees what a reader will get.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/context.h"
#include "base/files.h"
#include "formats/bcc4/write/writer.h"
#include "store/given_data.h"
#include "store/level_fit.h"
#include "store/writer_opening.h"

namespace bccsplat {

class WriterOutput {
 public:
  // All of them outlive it. stream: null for a file at the path of the settings, which gets its name with
  // finish().
  WriterOutput(const WriterOpening& opening, const LevelFits& fits, Measuring& measuring,
               std::unique_ptr<ByteSink> stream, const Context& context);

  // What is stored from now on is complete with this frame; the number of frames: at the end.
  void begin_turn(uint32_t frame) { now_.trigger = frame; }
  void store_slab(int32_t slab, const ChannelLevel& at, const SlabLayers& layers);
  void store_residuals(int channel, uint32_t frame, const FrameResiduals& residuals);
  // A mask waits for what is written next: so the container is made as late as without masks.
  void take_mask(int channel, uint32_t frame, std::vector<std::byte> runs);
  // Writes what an unfinished file shows, where the host asks for that.
  void show_if_due(const GivenData& given);

  // Stores what waits. What the file says may be completed from here on.
  void end();
  [[nodiscard]] VolumeInfo& info() { return container_->info(); }
  // Completes what `info`, that of the file, says of times and source, of so many frames.
  void describe(const GivenData& given, uint32_t frames, const FitReport& report, VolumeInfo& info) const;
  // Returns what a part has written, once.
  [[nodiscard]] std::vector<PartWrite> take_writes() { return std::move(writes_); }
  Bcc4Report finish() { return container_->finish(context_); }

 private:
  void make_container();
  [[nodiscard]] Bcc4WriterOptions container_options(const VolumeInfo& info) const;
  void store_masks();
  // Returns how many frames depend on the first `layers` layers alone, with the kernel of the file.
  [[nodiscard]] uint32_t frames_to_show(const GivenData& given, int32_t layers) const;
  [[nodiscard]] VolumeInfo info_to_show(const GivenData& given, uint32_t frames, int32_t layers) const;

  const WriterOpening& opening_;
  const LevelFits& fits_;
  Measuring& measuring_;
  std::unique_ptr<ByteSink> sink_; // until the container takes it
  Context context_;
  std::unique_ptr<Bcc4Writer> container_;
  struct WaitingMask {
    int channel;
    uint32_t frame;
    std::vector<std::byte> runs;
  };
  std::vector<WaitingMask> masks_;
  std::vector<PartWrite> writes_; // of a part
  PartWrite now_;                 // the write under way: trigger, channel, level and slab
  int32_t shown_slabs_ = 0;
};

} // namespace bccsplat
