// SPDX-License-Identifier: Apache-2.0
// How much of a picture's error follows its sheets: contours like the grain of wood, one per sheet.
#pragma once

#include "draw/image.h"

namespace bccsplat::bench {

// Amplitudes in steps of 8 bits, linear premultiplied values, of whichever of red, green and blue has the
// larger one.
struct SheetResidue {
  double sheets = 0; // of the error's wave of one period per sheet
  double beside = 0; // of one with 1.37 periods per sheet, for comparison: what has nothing to do with sheets
};

// The error of the picture, in blocks of 16 pixels a side that a surface covers and on which it runs through
// most of a sheet's distance at least; root mean square over the blocks. `truth` has a depth plane; `step` is
// the world length between the picture's sheets.
[[nodiscard]] SheetResidue sheet_residue(const Image& picture, const Image& truth, double step);

} // namespace bccsplat::bench
