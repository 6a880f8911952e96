// SPDX-License-Identifier: Apache-2.0
// Draws the controls through SDL's own renderer, because the backend for it is not in Debian's ImGui.
#pragma once

#include <SDL.h>
#include <imgui.h>

namespace viewer {

// Makes the font's texture; it lives as long as the renderer.
void upload_fonts(SDL_Renderer* renderer);
void draw_controls(SDL_Renderer* renderer, const ImDrawData& data);

} // namespace viewer
