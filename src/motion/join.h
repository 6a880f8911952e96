// SPDX-License-Identifier: Apache-2.0
// Matches in both directions of time become one flow halfway.
#pragma once

#include "motion/match.h"
#include "motion/nodes.h"

namespace bccsplat::motion {

// ahead: of the first frame in the second; back: of the second in the first. Each node has the velocity that
// most of what comes by agrees on, and where nothing does, what its neighbours have.
[[nodiscard]] Flow join(const Matches& ahead, const Matches& back);

} // namespace bccsplat::motion
