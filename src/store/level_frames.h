// SPDX-License-Identifier: Apache-2.0
// What the levels of a series are resampled from: level 0 from the source's frames, each other one from the
// frame of the level before it, halved along the axes where its lattice is coarse enough.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "base/context.h"
#include "fit/fit.h"
#include "fit/resample/halved_frame.h"

namespace bccsplat {

class LevelFrames {
 public:
  // levels: the options of their fits, level 0 first.
  LevelFrames(const std::vector<FitOptions>& levels, const Context& context);

  // Returns the samples of a frame that the coarser levels of a block are made of, by whole cells.
  [[nodiscard]] const Region& seen() const { return seen_; }

  // One frame at all levels.
  class Images {
   public:
    Images(const Images&) = delete;
    Images& operator=(const Images&) = delete;
    ~Images() = default;
    [[nodiscard]] FrameImage at(int level) const;

   private:
    friend class LevelFrames;
    Images(LevelFrames& frames, const PreparedFrame& source, float ringing);
    LevelFrames& frames_;
    const PreparedFrame& source_;
    std::vector<HalvedFrame> halved_; // by halver
  };
  // The frame must outlive its images. ringing: of the channel's fit.
  [[nodiscard]] Images make(const PreparedFrame& frame, float ringing) { return {*this, frame, ringing}; }

 private:
  void make_block_only(const std::vector<FitOptions>& levels);

  Context context_;
  std::vector<FrameHalver> halvers_; // each takes what the one before it made
  std::vector<size_t> used_;         // by level: how many of them
  Region seen_;
};

} // namespace bccsplat
