// SPDX-License-Identifier: Apache-2.0
#include "viewer/draw.h"

#include <cstddef>
#include <stdexcept>

namespace viewer {

void upload_fonts(SDL_Renderer* renderer) {
  ImFontAtlas& fonts = *ImGui::GetIO().Fonts;
  unsigned char* pixels = nullptr;
  int width = 0, height = 0;
  fonts.GetTexDataAsRGBA32(&pixels, &width, &height);
  SDL_Texture* const texture =
      SDL_CreateTexture(renderer, SDL_PIXELFORMAT_ABGR8888, SDL_TEXTUREACCESS_STATIC, width, height);
  if (!texture) throw std::runtime_error(SDL_GetError());
  SDL_UpdateTexture(texture, nullptr, pixels, width * 4);
  SDL_SetTextureBlendMode(texture, SDL_BLENDMODE_BLEND);
  fonts.SetTexID(texture);
}

void draw_controls(SDL_Renderer* renderer, const ImDrawData& data) {
  for (int l = 0; l < data.CmdListsCount; ++l) {
    const ImDrawList& list = *data.CmdLists[l];
    for (const ImDrawCmd& command : list.CmdBuffer) {
      const SDL_Rect clip{static_cast<int>(command.ClipRect.x), static_cast<int>(command.ClipRect.y),
                          static_cast<int>(command.ClipRect.z - command.ClipRect.x),
                          static_cast<int>(command.ClipRect.w - command.ClipRect.y)};
      SDL_RenderSetClipRect(renderer, &clip);
      const auto* const vertex = reinterpret_cast<const std::byte*>(list.VtxBuffer.Data + command.VtxOffset);
      const auto at = [&](size_t offset) { return reinterpret_cast<const float*>(vertex + offset); };
      SDL_RenderGeometryRaw(renderer, static_cast<SDL_Texture*>(command.GetTexID()),
                            at(offsetof(ImDrawVert, pos)), sizeof(ImDrawVert),
                            reinterpret_cast<const SDL_Color*>(at(offsetof(ImDrawVert, col))),
                            sizeof(ImDrawVert), at(offsetof(ImDrawVert, uv)), sizeof(ImDrawVert),
                            list.VtxBuffer.Size - static_cast<int>(command.VtxOffset),
                            list.IdxBuffer.Data + command.IdxOffset, command.ElemCount, sizeof(ImDrawIdx));
    }
  }
  SDL_RenderSetClipRect(renderer, nullptr);
}

} // namespace viewer
