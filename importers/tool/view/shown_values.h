// SPDX-License-Identifier: Apache-2.0
// Whether a transfer function shows any of a channel's values.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "bccsplat.h"

namespace bcc4 {

// Returns a sentence where next to none of the stored samples are visible, by points of value and opacity.
[[nodiscard]] std::optional<std::string> shows_nothing(const std::vector<std::array<double, 2>>& opacities,
                                                       const bccsplat_channel_info& channel);

} // namespace bcc4
