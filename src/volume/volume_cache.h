// SPDX-License-Identifier: Apache-2.0
// How large the caches of a volume are: what playing its series needs, and how a given size is shared.
#pragma once

#include <algorithm>
#include <cstdint>

#include "formats/bcc4/read/reader.h"
#include "kernel/kernel.h"

namespace bccsplat {

struct VolumeCache {
  uint64_t chunks = 0;       // decoded ones, of all channels
  uint64_t coefficients = 0; // of one channel and kernel, and the samples that they are made of
  // The size whose shares (share_cache) are no smaller.
  [[nodiscard]] uint64_t bytes() const { return std::max(chunks + coefficients, 3 * chunks); }
};

// Returns what a series needs that plays forward, up to half a frame a moment: a slab of chunks, the layers
// of coefficients in the kernel's reach, and those of samples in the prefilter's with what the next moment
// adds. A file of which parts are air is taken to fill at most twice as much as in the mean. Nothing for a
// volume without time.
[[nodiscard]] VolumeCache playing_cache(const Bcc4Reader& reader, const Kernel& kernel);

// A cache of a size: chunks get a third, but not more than they need before the others have what they do.
[[nodiscard]] VolumeCache share_cache(uint64_t bytes, const VolumeCache& playing);

// The size where a host names none: what playing needs, but not more than a quarter of the budget, whose
// rest is for slices and pictures, and half of the memory; at least a quarter of the budget, up to 1 GiB.
// memory: of the machine; budget: UINT64_MAX where there is none.
[[nodiscard]] uint64_t default_cache_bytes(const VolumeCache& playing, uint64_t budget, uint64_t memory);

} // namespace bccsplat
