// SPDX-License-Identifier: Apache-2.0
// Whether boxes of a frame overlap.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>

#include "fit/frame/frame.h"

namespace bccsplat {

// Returns the numbers of two boxes that share samples, rising; none where all are apart. Takes n log n steps
// of boxes that are apart.
[[nodiscard]] std::optional<std::array<size_t, 2>> find_overlap(std::span<const FrameBox> boxes);

} // namespace bccsplat
