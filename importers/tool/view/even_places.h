// SPDX-License-Identifier: Apache-2.0
// Places along unevenly spaced axes: people count samples, pictures are laid out by even positions.
#pragma once

#include <array>
#include <cstdint>

#include "tool/handles.h"

namespace bcc4 {

// Returns the even position of an index along an axis of space; along an even axis the index.
[[nodiscard]] double even_position(const Volume& volume, uint32_t axis, double index);
// Returns a hyperplane across an axis, given by samples, as one of even positions. Others are of even
// positions as they are.
[[nodiscard]] std::array<double, 5> even_plane(const Volume& volume, const double (&plane)[5]);

} // namespace bcc4
