// SPDX-License-Identifier: Apache-2.0
// What makes the slabs of a volume that is written, level by level: fits of the frames, or layers.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "base/context.h"
#include "fit/fit.h"
#include "formats/bcc4/info.h"
#include "store/level_frames.h"

namespace bccsplat {

// The options of a level: its lattice is made as that of level 0 is, of distances 2^level as large in space.
// margins: planes outside the faces of its own lattice.
[[nodiscard]] FitOptions options_of_level(FitOptions options, int level, const Int3& margins);

// The fits of all levels of a series, none before the first data. Level 0 prepares the frames of all, and
// tells what is missing before any of them takes a frame. Coarser levels come first, so that a coarse slab is
// one read.
class LevelFits {
 public:
  // Takes the slabs.
  using Store = std::function<void(int32_t slab, const ChannelLevel& at, const SlabLayers& layers)>;

  // options: of all levels, level 0 first. masks: takes those of level 0.
  void begin(const std::vector<FitOptions>& options, const Store& store, const MaskSink& masks,
             const Context& context);
  void clear() { fits_.clear(), frames_.reset(); }
  [[nodiscard]] bool begun() const { return !fits_.empty(); }
  [[nodiscard]] int coarsest() const { return static_cast<int>(fits_.size()) - 1; }
  [[nodiscard]] Fit& level(int level) { return *fits_[level]; }
  [[nodiscard]] Fit& fit() { return *fits_.front(); } // of level 0
  [[nodiscard]] const Fit& fit() const { return *fits_.front(); }
  [[nodiscard]] const Lattice4& lattice(int level = 0) const { return fits_[level]->lattice(); }

  // The next frame of a channel; scan: what the fit of level 0 found of it. ringing: of the channel there.
  void add_frame(int channel, std::span<const FrameBox> boxes, const FrameScan& scan, float ringing);
  // Puts the lattices of all levels into what a file says.
  void describe_lattices(VolumeInfo& info) const;
  // Returns the report of level 0, with the channels of coarser levels behind its own: of their samples the
  // file tells nothing but how many the stored type could not hold.
  [[nodiscard]] FitReport report() const;

 private:
  std::vector<std::unique_ptr<Fit>> fits_; // by level
  std::optional<LevelFrames> frames_;
};

} // namespace bccsplat
