// SPDX-License-Identifier: Apache-2.0
// A source of the corrections of one channel at its source samples (formats/bcc4.md, section 10): a .bcc4
// file, or memory.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/block_ref.h"
#include "base/error.h"
#include "base/vec.h"
#include "lattice/lattice.h"
#include "points/grid_value.h"

namespace bccsplat {

// How a correction falls off along an axis, up to the next source sample.
enum class CorrectionShape : uint8_t { tent, smooth };

inline constexpr int32_t correction_edge = 64; // source samples along an edge of a brick of corrections

// A brick of corrections, as the table of a frame lists it.
struct CorrectionBrick {
  uint32_t brick = 0;      // number, x fastest
  float low = 0, high = 0; // of its values
  uint32_t count = 0;      // corrections in it
  BlockRef block;          // where it is stored
};

// The bricks of a frame.
class CorrectionBricks {
 public:
  explicit CorrectionBricks(const std::array<uint32_t, 4>& dims); // source samples
  [[nodiscard]] uint64_t count() const;
  [[nodiscard]] Int3 origin(uint32_t brick) const; // source sample
  [[nodiscard]] uint32_t brick_of(const Int3& sample) const;
  [[nodiscard]] const std::array<int64_t, 3>& samples() const { return samples_; }

 private:
  std::array<int64_t, 3> samples_{}, bricks_{};
};

class CorrectionSource {
 public:
  // A frame without its bricks.
  struct Frame {
    std::vector<CorrectionBrick> table; // by rising number
    std::vector<GridValue> add;         // corrections that are in no brick, as older files have them
    std::vector<GridValue> set;         // values, air included, of samples in holes of the lattice
  };
  virtual ~CorrectionSource() = default;
  [[nodiscard]] virtual const Lattice4& lattice() const = 0;
  // Returns whether there are corrections; without, there may still be an error bound.
  [[nodiscard]] virtual bool any() const = 0;
  [[nodiscard]] virtual CorrectionShape shape() const = 0;
  [[nodiscard]] virtual double step() const = 0; // values are multiples of it
  // Returns how many samples of all frames have one; none: the tables of the frames have to tell.
  [[nodiscard]] virtual std::optional<uint64_t> told_count() const { return std::nullopt; }
  [[nodiscard]] virtual Frame read_frame(int64_t frame) const = 0;
  // Returns the corrections of a brick, at places counted from its first sample.
  [[nodiscard]] virtual std::vector<GridValue> read_brick(const CorrectionBrick& brick) const = 0;
  // Returns where what read_frame reads is stored.
  [[nodiscard]] virtual std::vector<ByteRange> places(int64_t frame) const = 0;
  // Returns whether a count goes on without what cannot be read for this reason.
  [[nodiscard]] virtual bool goes_without(const Error& failure) const = 0;
};

} // namespace bccsplat
