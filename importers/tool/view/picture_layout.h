// SPDX-License-Identifier: Apache-2.0
// What a picture shows: the volume, planes through it, or both on one sheet, and which part of the picture
// each of them has.
#pragma once

#include <array>
#include <vector>

#include "tool/handles.h"
#include "tool/view/picture_cut.h"
#include "tool/view/render_arguments.h"

namespace bcc4 {

// A part of a picture, in pixels from its top left corner.
struct Pane {
  uint32_t x = 0, y = 0;
  PictureSize size;
};

struct PictureLayout {
  int32_t kind = BCCSPLAT_LAYOUT_VOLUME;
  PictureSize whole;
  std::vector<Pane> planes; // three, or one of a map; none: the volume alone
  Pane volume;              // where there is one

  [[nodiscard]] bool has_volume() const {
    return kind == BCCSPLAT_LAYOUT_VOLUME || kind == BCCSPLAT_LAYOUT_BOTH;
  }
};

// Returns the layout that was asked for, or that of the kind of data where nothing else asks for a picture of
// the volume. size: of the volume's picture, where no size is given. Refuses options that planes have no use
// for.
[[nodiscard]] PictureLayout choose_layout(const RenderArguments& arguments, int32_t of_kind,
                                          const std::array<uint32_t, 2>& size);

} // namespace bcc4
