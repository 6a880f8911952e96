// SPDX-License-Identifier: Apache-2.0
// Which source samples of a series are missing (formats/bcc4.md, record 10), on the reading side. One rule
// tells it of any point of space-time, and all who look at the field ask here: a point has no value if the
// source sample nearest to it is missing, along each axis the later one of two at equal distance.
//
// Masks are read frame by frame, as far as they are looked at, and held as bits in a cache; frames that share
// a block share them.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "base/byte_range.h"
#include "base/context.h"
#include "base/lru_cache.h"
#include "base/vec.h"
#include "points/mask_source.h"

namespace bccsplat {

// The source sample that decides about a coordinate. Half a step of rounding is no reason for a point that is
// meant to lie half way to belong to the earlier one.
inline constexpr double nearest_rounding = 1e-9;
[[nodiscard]] inline int64_t nearest_sample(double position, int64_t n) {
  // What is cut off is the fraction: it is not negative.
  return static_cast<int64_t>(std::clamp(position + 0.5 + nearest_rounding, 0.0, static_cast<double>(n - 1)));
}
// The same along an axis that goes on beyond its samples.
[[nodiscard]] inline double nearest_place(double position) {
  return std::floor(position + 0.5 + nearest_rounding);
}
// Returns the sample at any position on a periodic axis; what is further off than 1e15 is no place of it.
[[nodiscard]] int64_t counted_sample(double position);
// The same, as the one of its n samples that it is.
[[nodiscard]] inline int64_t turned_sample(double position, int64_t n) {
  const int64_t at = counted_sample(position) % n;
  return at < 0 ? at + n : at;
}
// Which of x, y, z and t are periodic.
using TurningAxes = std::array<bool, 4>;

// How much of a region is missing. `some` may also stand where finding out more would take longer.
enum class Missing : uint8_t { none, some, all };

// The missing samples of a frame.
class FrameMask {
 public:
  // all: every sample is; else none, until they are added.
  FrameMask(const std::array<int64_t, 3>& samples, Reservation memory, bool all);
  [[nodiscard]] static uint64_t bytes_of(const std::array<int64_t, 3>& samples);

  void add(uint64_t begin, uint64_t end); // voxels
  void count_blocks();                    // once all are added: within() answers from then on

  // Tells of the samples first .. last, both included and in range: of a few rows exactly, else as the blocks
  // they touch tell.
  [[nodiscard]] Missing within(const std::array<int64_t, 3>& first, const std::array<int64_t, 3>& last) const;

  [[nodiscard]] bool at(const std::array<int64_t, 3>& sample) const {
    const uint64_t i = (sample[2] * n_[1] + sample[1]) * n_[0] + sample[0];
    return bits_[i / 64] >> (i % 64) & 1;
  }
  [[nodiscard]] uint64_t count() const;
  [[nodiscard]] uint64_t bytes() const { return (bits_.size() + before_.size()) * sizeof(uint64_t); }

 private:
  // Blocks of 8 samples along each axis, the last ones cut off.
  static constexpr int64_t block_edge = 8;
  [[nodiscard]] static std::array<int64_t, 3> blocks_of(const std::array<int64_t, 3>& samples);
  // Returns how many samples are missing in the blocks below (bx, by, bz), which may be as many as there are.
  [[nodiscard]] uint64_t& before(int64_t bx, int64_t by, int64_t bz);
  [[nodiscard]] uint64_t before(int64_t bx, int64_t by, int64_t bz) const;
  [[nodiscard]] size_t before_at(int64_t bx, int64_t by, int64_t bz) const;
  [[nodiscard]] Missing within_blocks(const std::array<int64_t, 3>& first,
                                      const std::array<int64_t, 3>& last) const;
  // Returns at most 64 samples of a row along x, the first one in the lowest bit.
  [[nodiscard]] uint64_t row_bits(const std::array<int64_t, 3>& first, int64_t count) const;

  std::array<int64_t, 3> n_, blocks_;
  std::vector<uint64_t> bits_, before_;
  Reservation memory_;
};
using FrameMaskPtr = std::shared_ptr<const FrameMask>;

class Masks {
 public:
  // budget: of the masks; outlives them.
  Masks(std::unique_ptr<const MaskSource> source, MemoryBudget& budget, uint64_t cache_bytes);

  [[nodiscard]] const std::array<int64_t, 4>& samples() const { return n_; } // along x, y, z, t
  [[nodiscard]] const TurningAxes& turning() const { return turning_; }
  // The source sample that decides about a coordinate along an axis.
  [[nodiscard]] int64_t nearest(double position, size_t axis) const;
  // The frame of a moment; of a periodic series counted on beyond its ends.
  [[nodiscard]] int64_t counted_frame(double moment) const;
  // The number may be counted on in a periodic series. Null: nothing is missing. Where the source goes on
  // without a damaged mask, the nearest whole one replaces it; where none is whole, nothing counts as
  // missing.
  [[nodiscard]] FrameMaskPtr frame(int64_t counted) const;
  // Appends where the masks of counted frames stand; missing: but those that are held. The read of masks
  // that two frames share is listed twice.
  void list_reads(int64_t first, int64_t last, bool missing, std::vector<ByteRange>& out) const;
  // Returns how many samples of the series are missing; where the file does not tell, as far as its masks are
  // whole.
  [[nodiscard]] uint64_t count() const;

  // Makes values, and gradients (empty, or one per point), at missing points (x, y, z, t) of index space NaN;
  // returns how many more these are.
  uint64_t hide(std::span<const Vec4> points, std::span<float> values,
                std::span<std::array<float, 4>> gradients, const Context& context) const;
  // Sets to 1 what is missing.
  void mark(std::span<const Vec4> points, std::span<uint8_t> missing, const Context& context) const;

 private:
  [[nodiscard]] FrameMaskPtr read(int64_t frame, uint64_t offset) const;
  // Calls body(i) for the points that are missing.
  template<class Body>
  void each_missing(std::span<const Vec4> points, const Context& context, const Body& body) const;

  std::unique_ptr<const MaskSource> source_;
  std::array<int64_t, 4> n_{};
  TurningAxes turning_{};
  MemoryBudget& budget_;
  mutable LruCache<uint64_t, FrameMask> cache_; // by offset of the block
  // The masks in use, which the cache may have dropped.
  mutable std::mutex mutex_;
  mutable std::map<uint64_t, std::weak_ptr<const FrameMask>> in_use_;
};

} // namespace bccsplat
