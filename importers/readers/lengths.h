// SPDX-License-Identifier: Apache-2.0
// Units of length, and degrees of longitude and latitude, by the names that files give them.
#pragma once

#include <optional>
#include <string>

namespace bcc4 {

// Returns the name that a unit has here, of those that one is known by: a micrometre has many. Others stay
// as they are; pixels are none.
[[nodiscard]] std::string length_unit(const std::string& name);

// Returns the factor that takes lengths in one unit to the other, exact where it is a power of ten; nothing
// where one of two unlike names is not known.
[[nodiscard]] std::optional<double> length_ratio(const std::string& from, const std::string& to);

} // namespace bcc4
