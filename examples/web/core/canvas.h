// SPDX-License-Identifier: Apache-2.0
// The page's canvas and the texture that pictures are drawn into before they are shown on it.
#pragma once

#include <array>
#include <cstdint>

#include "viewer.h"

namespace web {

// The frame of a texture of this size.
[[nodiscard]] bccsplat_frame* canvas_frame(uint32_t width, uint32_t height);
// Shows what is in the texture over a colour of the display. exposure > 0: of X-rays, as shades of grey.
// Returns when it is drawn.
void show_canvas(const std::array<double, 3>& background, double exposure);
// The integral in the texture that is shown white: hardly a ray exceeds it.
[[nodiscard]] double white_pixel();
// Forgets both: their context is gone, or another device draws.
void drop_canvas();

} // namespace web
