// SPDX-License-Identifier: Apache-2.0
// The pixels of a tile that have no value on a sheet. Whole rectangles of pixels are asked for at once, as
// most of them lie where nothing or everything is missing.
#pragma once

#include <cstdint>

#include "field/slice.h"
#include "splat/plan/plan.h"
#include "splat/sheet/sheet.h"
#include "view/pixel_rect.h"
#include "view/view.h"

namespace bccsplat {

// Marks at `hole`, s.pitch per row, the pixels of s.seen whose sample is a hole; what it says of pixels whose
// segment is empty, and of those beside s.seen, means nothing. Where it returns none or all, `hole` is not
// written.
[[nodiscard]] Missing find_holes(const Slice& slice, const SheetView& view, const SheetArgs& s,
                                 uint8_t* hole);

} // namespace bccsplat
