// SPDX-License-Identifier: Apache-2.0
// Hands out frames in order, while the next one is read on a second thread where the reader allows that.
#pragma once

#include <future>
#include <optional>

#include "series/frame_reader.h"

namespace bccsplat::series {

class ReadAhead {
 public:
  // Channels of a frame come one after the other, then the next frame. The reader must not be used meanwhile.
  explicit ReadAhead(FrameReader& reader) : ReadAhead(reader, 0, reader.description().dims[3]) {}
  // Reads only frames first .. end - 1.
  ReadAhead(FrameReader& reader, uint64_t first, uint64_t end)
      : reader_(reader), end_(end), channels_(reader.description().channels.size()), frame_(first) {
    start();
  }
  // The same of some samples of each frame (FrameReader::read_box).
  ReadAhead(FrameReader& reader, uint64_t first, uint64_t end, const SampleBox& wanted)
      : reader_(reader), end_(end), channels_(reader.description().channels.size()), wanted_(wanted),
        frame_(first) {
    start();
  }
  // Returns the next frame; throws what the reader threw.
  [[nodiscard]] Frame next() {
    Frame frame = pending_.get();
    if (++channel_ == channels_) {
      channel_ = 0;
      ++frame_;
    }
    start();
    return frame;
  }

 private:
  void start() {
    if (frame_ == end_) return;
    const auto when = reader_.any_thread() ? std::launch::async : std::launch::deferred;
    pending_ = std::async(when, [this, f = frame_, c = channel_] {
      return wanted_ ? reader_.read_box(f, c, *wanted_) : reader_.read(f, c);
    });
  }

  FrameReader& reader_;
  uint64_t end_;
  size_t channels_;
  std::optional<SampleBox> wanted_; // none: all of each frame
  uint64_t frame_;
  size_t channel_ = 0;
  std::future<Frame> pending_; // its destructor waits for the thread
};

} // namespace bccsplat::series
