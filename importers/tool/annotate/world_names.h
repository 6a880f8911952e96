// SPDX-License-Identifier: Apache-2.0
// What the directions of a world are called: by the patient's sides, or by the points of the compass.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "tool/handles.h"

namespace bcc4 {

// The names of the lower and the higher end of x, y and z; "": the axis has its letter.
using WorldNames = std::array<std::array<std::string, 2>, 3>;

// Returns the names where the space of a file is named (RAS, LPS), or where x and y are in degrees; none
// else.
[[nodiscard]] std::optional<WorldNames> world_names(const Volume& volume);

} // namespace bcc4
