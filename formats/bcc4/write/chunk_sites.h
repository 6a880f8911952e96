// SPDX-License-Identifier: Apache-2.0
// The sites of a chunk, out of the layers of a slab.
#pragma once

#include <cstdint>
#include <span>

#include "formats/bcc4/coding/chunk.h"
#include "formats/bcc4/coding/codes.h"
#include "points/sample_layer.h"

namespace bccsplat {

// Returns the brick at a position, of which a layer may be too small to have one.
[[nodiscard]] const SampleBrick& brick_at(const SampleLayer& layer, const Int3& position);

// Collects the sites of one chunk; there are no codes where all of it is air. `clamped` counts values that
// the type cannot hold; refuses those that are not finite.
[[nodiscard]] ChunkSites collect_sites(const ChunkShape& shape, std::span<const SampleLayer> layers,
                                       const Int3& position, const SampleCoder& coder, uint64_t& clamped);

} // namespace bccsplat
