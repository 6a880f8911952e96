// SPDX-License-Identifier: Apache-2.0
// What the outermost plane, or layer, of two outside an end holds besides its own.
//
// Readers take mirror images beyond it, which the field is not: on BCC and D4* it makes up for them. With s_k
// for what stands k planes outside, plane 2 holds s_2 + (s_0 - s_1 + s_3 - s_4) / 4 in place of s_2. The
// factors are those that bring the field between the end and a sample inside closest to waves in the ball,
// with the default kernel: found by search among all combinations of s_4 - s_0 and s_3 - s_1 on planes 1 and
// 2, in space and, with the same result, in time (tests/bench/notes/ends.md).
#pragma once

#include <array>
#include <cstdint>

namespace bccsplat {

struct AgainstMirrors {
  int plane; // outside
  float factor;
};
inline constexpr std::array<AgainstMirrors, 4> against_mirrors{
    {{0, .25f}, {1, -.25f}, {3, .25f}, {4, -.25f}}};
inline constexpr int32_t mended_plane = 2;

} // namespace bccsplat
