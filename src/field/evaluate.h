// SPDX-License-Identifier: Apache-2.0
// The field at arbitrary points: of a slice (slice.h) and of the 4D volume.
#pragma once

#include <array>
#include <span>

#include "base/context.h"
#include "base/vec.h"
#include "field/coefficients/coefficients.h"
#include "field/slice.h"

namespace bccsplat {

// The 4D field at points (x, y, z, t) in source index units. values: absolute; gradients: empty, or d/dx d/dy
// d/dz d/dt per index unit; corrections and masks that the coefficients know of are in both. Points outside
// the domain or in holes get NaN; the counts are returned. A static volume ignores t. Points that share a
// stretch of time share the coefficient layers: any order is fine, a batch is sorted by time inside.
EvaluateMisses evaluate4(const Coefficients& coefficients, std::span<const Vec4> points,
                         std::span<float> values, std::span<std::array<float, 4>> gradients,
                         const Context& context);

// Does the same for points anywhere near the domain, beyond whose ends the field continues as its mirror
// image; `holes` (empty, or one per point) gets 1 where the nearest site is a hole, or the nearest
// source sample missing. Values are relative to the base of the field.
void evaluate4_mirrored(const Coefficients& coefficients, std::span<const Vec4> points,
                        std::span<float> values, std::span<std::array<float, 4>> gradients,
                        std::span<uint8_t> holes, const Context& context);

// The first and the last coefficient layer, of those counted on beyond the ends, that values at moments from
// t0 to t1 (frames) are made of.
[[nodiscard]] std::array<int32_t, 2> layers_of_moments(const Lattice4& lattice, const Kernel& kernel,
                                                       double t0, double t1);

} // namespace bccsplat
