// SPDX-License-Identifier: Apache-2.0
// Which bytes of its file a cut reads, and what a host hears of where these are not there yet.
#pragma once

#include <span>
#include <vector>

#include "base/would_block.h"
#include "volume/open_slice.h"

namespace bccsplat {

// Returns the ranges, rising and merged over small gaps; missing: those alone whose bytes are not held yet.
[[nodiscard]] std::vector<ByteRange> read_ranges(const OpenVolume& volume, const SliceRequest& asked,
                                                 bool missing, const Context& context);

// Throws WouldBlock with all that cuts of a level lack, as far as it is known where that stands. first: what
// one of them has had to wait for.
[[noreturn]] void tell_lacking(const OpenVolume& volume, uint32_t level, std::span<const CutPlan> plans,
                               const WouldBlock& first, const Context& context);

// Runs a body that makes cuts, which ends at the first bytes that are not there: tells of those of all.
template<class Body>
auto or_all_lacking(const OpenVolume& volume, uint32_t level, std::span<const CutPlan> plans,
                    const Context& context, const Body& body) {
  try {
    return body();
  } catch (const WouldBlock& first) {
    tell_lacking(volume, level, plans, first, context);
  }
}

} // namespace bccsplat
