// SPDX-License-Identifier: Apache-2.0
// Index space -> world, 4x4 row-major.
#pragma once

#include <array>
#include <cstddef>

namespace bcc4 {

using std::size_t;
using Affine = std::array<double, 16>;

// Makes an affine whose columns are the world steps of one sample along x, y and z.
[[nodiscard]] Affine affine_from_columns(const std::array<std::array<double, 3>, 3>& columns,
                                         const std::array<double, 3>& origin);
[[nodiscard]] double determinant(const Affine& m);
// Returns whether the numbers are finite and the three steps do not lie in a plane.
[[nodiscard]] bool spans_volume(const Affine& m);
// Returns the affine of a grid whose sample 0 is at index `begin` of this one.
[[nodiscard]] Affine moved_origin(const Affine& affine, const std::array<double, 3>& begin);

} // namespace bcc4
