// SPDX-License-Identifier: Apache-2.0
// Blocks of whole numbers: what waits for the filter in time takes half the memory of floats, where what is
// lost by it is nothing beside the rounding to the stored type.
#pragma once

#include <array>

#include "fit/quantise.h"
#include "fit/site_block.h"

namespace bccsplat {

// The unit of the values of a channel, a power of two and at most a 64th of the step between stored values:
// their error becomes larger by 0.001 dB. 0: floats, nothing is rounded.
[[nodiscard]] float packing_unit(const Quantiser& quantiser);

// The block in units where all values of its size[2] planes of size[1] rows fit; else, and where unit is 0,
// the block itself.
[[nodiscard]] SiteBlockPtr pack(FloatSitesPtr block, const Int3& size, float unit, SiteBlockPool& pool);

struct alignas(64) SiteValues : std::array<float, brick_sites> {};

// The values of a block; packed ones are written to `room`.
[[nodiscard]] const float* unpack(const SiteBlock& block, float unit, SiteValues& room);

} // namespace bccsplat
