// SPDX-License-Identifier: Apache-2.0
// The ways into a writer: frames, layers, or a field of the host. Holds what has been given so far; needs the
// fits that take the data, the comparison that holds some of them, and the output that shows what is there.
//
// Data are checked first, which changes nothing where they are refused, and then added; the order of calls is
// the caller's. Channels are those of the opening.
#pragma once

#include <cstdint>
#include <span>
#include <utility>

#include "base/context.h"
#include "store/field_samples.h"
#include "store/writer_output.h"

namespace bccsplat {

class WriterInput {
 public:
  // All of them outlive it.
  WriterInput(WriterOpening& opening, LevelFits& fits, Measuring& measuring, WriterOutput& output,
              const Context& context);

  [[nodiscard]] FrameScan check_frame(uint32_t channel, double time, std::span<const FrameBox> boxes);
  // scan: of the check.
  void add_frame(uint32_t channel, double time, std::span<const FrameBox> boxes, const FrameScan& scan);
  [[nodiscard]] DirectLayerScan check_layer(uint32_t channel, int64_t layer, std::span<const float> samples);
  void add_layer(uint32_t channel, std::span<const float> samples, const DirectLayerScan& scan);
  void check_field(uint32_t channel);
  void add_field(uint32_t channel, const Field& field);

  [[nodiscard]] const GivenData& given() const { return given_; }

 private:
  // Checks data once they, being the first, have settled what first data do; where they are refused nothing
  // is.
  template<class Check>
  auto check_settled(GivenData::Kind kind, uint32_t channel, SourceType type, const Check& check) {
    if (fits_.begun()) return check();
    WriterOpening::Settled before = opening_.settled();
    try {
      begin(kind, channel, type);
      return check();
    } catch (...) {
      fits_.clear();
      given_.kind = GivenData::Kind::none;
      opening_.restore(std::move(before));
      throw;
    }
  }
  void begin(GivenData::Kind kind, uint32_t first_channel, SourceType first_type);
  // frames_known: the source samples of frames will be given.
  void begin_measuring(bool frames_known);
  void begin_measuring_levels();
  void require_kind(GivenData::Kind kind) const;
  void require_layers() const;
  void check_time(uint64_t frame, double time) const;
  void check_boxes(uint64_t frame, std::span<const FrameBox> boxes) const;
  // Throws limit_exceeded where labels would not come back whole from floats.
  void require_exact_labels(uint32_t channel, std::span<const FrameBox> boxes, const FrameScan& scan) const;
  void finish_step(uint32_t channel);

  WriterOpening& opening_;
  LevelFits& fits_;
  Measuring& measuring_;
  WriterOutput& output_;
  Context context_;
  GivenData given_;
};

} // namespace bccsplat
