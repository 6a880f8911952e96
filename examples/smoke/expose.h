// SPDX-License-Identifier: Apache-2.0
// Makes what is recorded of the solver's density.
#pragma once

#include "smoke/grid.h"

namespace smoke {

// Averages each cell with its neighbours, 1/4 1/2 1/4 along each axis, as a detector would: the sharpest
// edges of the solver belong to its grid and not to the smoke, and no later sampling could hold them. The
// faint rim then ends at exactly 0, so that the air around the smoke is air.
Grid expose(const Grid& density);

} // namespace smoke
