// SPDX-License-Identifier: Apache-2.0
// Blocks of whole numbers: what waits for the filter in time takes less than half the memory of floats, where
// what is lost by it is nothing beside the rounding to the stored type.
#pragma once

#include <array>

#include "fit/kept/quantise.h"
#include "fit/kept/site_block.h"

namespace bccsplat {

// The finest unit of the values of a channel, a power of two and at most a 64th of the step between stored
// values; 0: floats, nothing is rounded.
[[nodiscard]] float packing_unit(const Quantiser& quantiser);

// The coarsest one for values of that unit: their error becomes larger by 0.02 dB, where 12 bits hold nothing
// finer.
[[nodiscard]] constexpr float coarsest_unit(float finest) { return 4 * finest; }

// The block in whole numbers where the values of its first sites, size[0] x size[1] x size[2], fit a form;
// else, and where unit is 0, the block itself.
[[nodiscard]] SiteBlockPtr pack(FloatSitesPtr block, const Int3& size, float unit, SiteBlockPool& pool);

struct alignas(64) SiteValues : std::array<float, brick_sites> {};

// The values of plane z of a block; packed ones are written to `room`, brick_rows of them.
[[nodiscard]] const float* plane_of(const SiteBlock& block, int z, float* room);
// The value of a site, (z*16 + y)*16 + x.
[[nodiscard]] float value_of(const SiteBlock& block, int site);

} // namespace bccsplat
