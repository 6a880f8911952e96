// SPDX-License-Identifier: Apache-2.0
// Hyperplanes by what a test says about them.
#pragma once

#include "field/hyperplane.h"

namespace bccsplat::test {

// The normal may have any length.
inline Hyperplane through(const Vec4& normal, const Vec4& point) {
  return {normal[0], normal[1], normal[2], normal[3], -dot4(normal, point)};
}

} // namespace bccsplat::test
