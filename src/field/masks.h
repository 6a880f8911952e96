// SPDX-License-Identifier: Apache-2.0
// Which source samples of a file are missing (formats/bcc4.md, record 10), on the reading side. One rule
// tells it of any point of space-time, and all who look at the field ask here: a point has no value if the
// source sample nearest to it is missing, along each axis the later one of two at equal distance.
//
// Masks are read frame by frame, as far as they are looked at, and held as bits in a cache; frames that share
// a block share them.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "base/context.h"
#include "base/vec.h"
#include "formats/bcc4/bcc4.h"
#include "formats/bcc4/cache.h"

namespace bccsplat {

// The missing samples of a frame.
class FrameMask {
 public:
  // all: every sample is; else none, until they are added.
  FrameMask(const std::array<int64_t, 3>& samples, Reservation memory, bool all);
  [[nodiscard]] static uint64_t bytes_of(const std::array<int64_t, 3>& samples);

  void add(uint64_t begin, uint64_t end); // voxels

  [[nodiscard]] bool at(const std::array<int64_t, 3>& sample) const {
    const auto i = static_cast<uint64_t>((sample[2] * n_[1] + sample[1]) * n_[0] + sample[0]);
    return bits_[i / 64] >> (i % 64) & 1;
  }
  [[nodiscard]] uint64_t count() const;
  [[nodiscard]] uint64_t bytes() const { return bits_.size() * sizeof(uint64_t); }

 private:
  std::array<int64_t, 3> n_;
  std::vector<uint64_t> bits_;
  Reservation memory_;
};
using FrameMaskPtr = std::shared_ptr<const FrameMask>;

class Masks {
 public:
  // budget: of the masks; outlives them.
  Masks(std::shared_ptr<const Bcc4Reader> reader, int channel, MemoryBudget& budget, uint64_t cache_bytes);

  [[nodiscard]] const std::array<int64_t, 4>& samples() const { return n_; } // along x, y, z, t
  [[nodiscard]] bool periodic() const { return periodic_; }                  // in time
  // The source sample that decides about a coordinate along an axis.
  [[nodiscard]] int64_t nearest(double position, size_t axis) const;
  // The frame of a moment; of a periodic series counted on beyond its ends.
  [[nodiscard]] int64_t counted_frame(double moment) const;
  // Of a periodic series the number may be counted on. Null: nothing is missing. Of a file that is salvaged a
  // damaged mask is that of the nearest frame whose mask is whole; where none is, nothing counts as missing.
  [[nodiscard]] FrameMaskPtr frame(int64_t counted) const;
  // How many samples of the series are missing, as far as the file is whole.
  [[nodiscard]] uint64_t count() const;

  // Makes values, and gradients (empty, or one per point), at missing points (x, y, z, t) of index space NaN;
  // returns how many more these are.
  uint64_t hide(std::span<const Vec4> points, std::span<float> values,
                std::span<std::array<float, 4>> gradients, const Context& context) const;
  // Sets to 1 what is missing.
  void mark(std::span<const Vec4> points, std::span<uint8_t> missing, const Context& context) const;

 private:
  [[nodiscard]] const std::vector<BlockRef>& blocks() const {
    return reader_->info().channels[static_cast<size_t>(channel_)].masks;
  }
  [[nodiscard]] FrameMaskPtr read(int64_t frame) const;
  [[nodiscard]] FrameMaskPtr read_nearest_whole(int64_t frame) const;
  // Calls body(i) for the points that are missing.
  template<class Body>
  void each_missing(std::span<const Vec4> points, const Context& context, const Body& body) const;

  std::shared_ptr<const Bcc4Reader> reader_;
  int channel_;
  std::array<int64_t, 4> n_{};
  bool periodic_;
  MemoryBudget& budget_;
  mutable LruCache<uint64_t, FrameMask> cache_; // by offset of the block
  // Those in use that the cache may have dropped.
  mutable std::mutex mutex_;
  mutable std::map<uint64_t, std::weak_ptr<const FrameMask>> in_use_;
};

// The masks of the frames that a slice meets: points of slice space are missing as those of the volume are.
class SliceMask {
 public:
  // origin, basis: as of Slice. frames: `first` and those behind it, as counted, null where nothing is
  // missing.
  SliceMask(const Masks& masks, const Vec4& origin, const std::array<Vec4, 3>& basis, int64_t first,
            std::vector<FrameMaskPtr> frames);

  [[nodiscard]] bool missing(const Vec3& uvw) const;
  // Whether any sample of its frames is.
  [[nodiscard]] bool any() const;
  // What is missing here and in all the others.
  [[nodiscard]] SliceMask also(std::vector<std::shared_ptr<const SliceMask>> others) const;

 private:
  std::array<int64_t, 4> n_;
  bool periodic_;
  Vec4 origin_;
  std::array<Vec4, 3> basis_;
  int64_t first_;
  std::vector<FrameMaskPtr> frames_;
  std::vector<std::shared_ptr<const SliceMask>> others_;
};

} // namespace bccsplat
