// SPDX-License-Identifier: Apache-2.0
// Values of an open volume at points, in its index space or in the world.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "base/context.h"
#include "field/evaluate.h"
#include "volume/open_volume.h"

namespace bccsplat {

// evaluate4() of a channel: (x, y, z, t) in index units. Reads no more than what is around the points, while
// these are few, or in few places.
EvaluateMisses values_at(const OpenVolume& volume, uint32_t channel, std::span<const Vec4> points,
                         std::span<float> values, std::span<std::array<float, 4>> gradients,
                         const Context& context);
// The same of (x, y, z, time) in the volume's world; gradients per world length and time unit.
EvaluateMisses values_at_world(const OpenVolume& volume, uint32_t channel, std::span<const Vec4> points,
                               std::span<float> values, std::span<std::array<float, 4>> gradients,
                               const Context& context);

// Says of the first point that lies outside which one it is, and along which axis of the index space. world:
// as of values_at_world.
[[nodiscard]] std::string first_outside(const OpenVolume& volume, std::span<const Vec4> points, bool world);

} // namespace bccsplat
