// SPDX-License-Identifier: Apache-2.0
// What a picture makes of the samples along a ray.
#pragma once

#include <cstdint>

namespace bccsplat {

enum class RenderMode : uint8_t { composite = 1, isosurface = 2, xray = 3, maximum = 4 };

} // namespace bccsplat
