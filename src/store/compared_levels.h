// SPDX-License-Identifier: Apache-2.0
// How far the coarser levels of a series are off, where nobody compared them with the source: parts in blocks
// of space do not see whole frames.
#pragma once

#include <span>

#include "base/context.h"
#include "fit/fit.h"
#include "store/join.h"

namespace bccsplat {

// Adds to info.errors how far each coarser level is from level 0, in a few boxes of at most three frames;
// nothing where any level was measured. Boxes are those where the coarsest level bends most, or has most
// that is not air. fits: what the channels counted.
void compare_levels(const SeriesParts& parts, std::span<const FitChannelReport> fits, VolumeInfo& info,
                    const Context& context);

} // namespace bccsplat
