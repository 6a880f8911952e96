// SPDX-License-Identifier: Apache-2.0
// The surfaces of --iso.
#pragma once

#include <string>
#include <vector>

#include "bccsplat.h"

namespace bcc4 {

// "V[:OPACITY[:#RRGGBB]]", several with commas. The colour is one of a display.
[[nodiscard]] std::vector<bccsplat_iso_surface> parse_surfaces(const std::string& text);

} // namespace bcc4
