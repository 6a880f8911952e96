// SPDX-License-Identifier: Apache-2.0
// Writes a .bcc4 file slab by slab (formats/bcc4.md).
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/context.h"
#include "base/files.h"
#include "formats/bcc4/coding/residuals.h"
#include "formats/bcc4/file_limits.h"
#include "formats/bcc4/info.h"
#include "points/brick.h"
#include "points/sample_layer.h"

namespace bccsplat {

struct Bcc4Report {
  Bcc4Bytes bytes;
  uint64_t chunks = 0;
  uint64_t bytes_corrections = 0;                  // of the index
  uint64_t slabs_reused = 0;                       // taken from an earlier writer or file, not coded again
  uint64_t sites_total = 0;                        // all channels
  uint64_t sites_kept = 0, holes = 0, clamped = 0; // all channels
};

class Bcc4Journal; // journal.h
class Bcc4Reader;

struct Bcc4WriterOptions {
  int level = 6;            // of deflate, 1 (fast) .. 9 (small); 0: raw chunks, usable from a mapping
  uint64_t data_offset = 0; // where the first chunk may go at the earliest; what lies before stays unused
  // Records what has been written, for a writer that comes after a crash: slabs that an earlier one recorded
  // are not coded again. The sink must be the file of the earlier one (Partial::taken_over).
  std::shared_ptr<Bcc4Journal> journal{};
  uint32_t fingerprint = 0; // of what decides the samples but is not in the VolumeInfo
  // A finished file whose first slabs are those to be written: their chunks are copied.
  std::shared_ptr<const Bcc4Reader> earlier{};
  int32_t earlier_slabs = 0;
};

class Bcc4Writer {
 public:
  Bcc4Writer(std::unique_ptr<ByteSink> sink, const VolumeInfo& initial,
             const Bcc4WriterOptions& options = {});
  ~Bcc4Writer(); // without finish, nothing is left under the final name
  Bcc4Writer(const Bcc4Writer&) = delete;
  Bcc4Writer& operator=(const Bcc4Writer&) = delete;

  // Writes the layers of one slab of one channel at a level: slab_layers of them, fewer only at the end of
  // the series. Bricks hold values minus air; a hole counts as kept. The slabs of a channel at a level rise;
  // those of a periodic series may begin with any, and end with those before it. A slab that is left out is
  // air. Integer types round to nearest and clamp. Values must be finite (Code::nonfinite_value). rounded:
  // the sum of the squares by which values were rounded to those given; of tiles it is a part of the error
  // that their sites may have, which is kept (else Code::bound_not_met).
  void write_slab(int32_t slab, const ChannelLevel& at, std::span<const SampleLayer> layers,
                  const Context& context, double rounded = 0);
  void write_slab(int32_t slab, const ChannelLevel& at, std::span<const BrickLayer> layers,
                  const Context& context);

  // Returns what a reader will get of these layers of a slab, as codes; a file of tiles rounds samples as it
  // codes them. For the slab that was just written it is at hand once; any other is coded for it.
  [[nodiscard]] std::vector<SampleLayer> as_read(int32_t slab, const ChannelLevel& at,
                                                 std::span<const SampleLayer> layers, const Context& context,
                                                 double rounded = 0);

  // Writes a slab by copying its chunks, undecoded, from files of equal coding that have some of its bricks
  // each. Throws invalid_argument where two have the same.
  void copy_slab(int32_t slab, const ChannelLevel& at, std::span<const Bcc4Reader* const> from);
  void copy_slab(int32_t slab, const ChannelLevel& at, const Bcc4Reader& from) {
    const Bcc4Reader* const one = &from;
    copy_slab(slab, at, {&one, 1});
  }

  // Write the corrections of one frame, in any order of channels and frames; a frame that gets none has none.
  // Corrections to add go into bricks where the channel's are local (ResidualInfo).
  void write_residuals(int channel, uint32_t frame, const FrameResiduals& residuals, const Context& context);
  // Copies them from files that have those of some of its samples each; see FrameBlocks::copy_corrections.
  void copy_residuals(int channel, uint32_t frame, std::span<const Bcc4Reader* const> from,
                      const Context& context);
  // Write which samples of one frame are missing, as MaskRunWriter has it; empty: none.
  void write_mask(int channel, uint32_t frame, std::span<const std::byte> runs, const Context& context);
  void copy_mask(int channel, uint32_t frame, const Bcc4Reader& from);
  // The same of files that are blocks of space: a sample is missing where it is in one of them.
  void copy_mask(int channel, uint32_t frame, std::span<const Bcc4Reader* const> from,
                 const Context& context);
  // Returns how many slabs every channel has at every level; 0 where some have more than others.
  [[nodiscard]] int32_t common_slabs() const;
  // Lets readers see an unfinished series: puts index, metadata and a root of it behind what is written,
  // durable before the root, and goes on. info: what is said of the series, a whole one of dims[3] frames and
  // of the layers of common_slabs(), completed as for finish.
  void show(VolumeInfo info, const Context& context);
  // The caller completes dims[3], last_layer (of all levels), times and statistics before finish; what
  // decides how samples are coded may not change any more.
  [[nodiscard]] VolumeInfo& info();
  // Writes index, metadata and roots and commits the sink.
  Bcc4Report finish(const Context& context);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

} // namespace bccsplat
