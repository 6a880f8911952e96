// SPDX-License-Identifier: Apache-2.0
// A source of the missing source samples of one channel: a .bcc4 file, or memory.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "base/byte_range.h"
#include "base/error.h"
#include "lattice/lattice.h"

namespace bccsplat {

// Voxels begin .. end - 1 of a frame are missing, voxel = (z * Ny + y) * Nx + x.
using MaskRunBody = std::function<void(uint64_t begin, uint64_t end)>;

class MaskSource {
 public:
  virtual ~MaskSource() = default;
  [[nodiscard]] virtual const Lattice4& lattice() const = 0;
  // Returns where the mask of a frame is stored: frames with one place share one mask. None: no sample of the
  // frame is missing. frame: in [0, dims[3]).
  [[nodiscard]] virtual std::optional<ByteRange> place(int64_t frame) const = 0;
  // Returns how many samples of all frames are missing; none: the masks have to tell.
  [[nodiscard]] virtual std::optional<uint64_t> told_count() const { return std::nullopt; }
  // Calls body for each run of missing samples of a frame, in rising order. Damage throws.
  virtual void read_runs(int64_t frame, const MaskRunBody& body) const = 0;
  // Returns whether the nearest whole mask in time replaces one that cannot be read for this reason.
  [[nodiscard]] virtual bool goes_without(const Error& failure) const = 0;
};

} // namespace bccsplat
