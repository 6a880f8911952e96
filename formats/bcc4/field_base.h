// SPDX-License-Identifier: Apache-2.0
// The value that the field of a channel is built up from.
//
// A kernel's sum over the sites ripples about 1, and so does a constant, by a share of its distance from the
// base of the field: base + sum of (c - base) K. The sum is linear: where no site is left out any base gives
// the same field but for that ripple, and a base among the values does away with it. Where sites are left out
// they are the air that the base is then, exactly.
#pragma once

#include "formats/bcc4/info.h"

namespace bccsplat {

// Whether air is further from all values of a range than these from each other.
[[nodiscard]] bool is_far(float air, const Range& values);
[[nodiscard]] float middle(const Range& values);

// Air, but where no site of the channel is air, and air is far from them: then their middle. All sites are
// stored then, or those that are left out are missing data, as no source sample is near air and masks tell
// what is missing. Corrections are differences from the field above air: it stays theirs.
[[nodiscard]] float field_base(const VolumeInfo& info, const ChannelInfo& channel);

} // namespace bccsplat
