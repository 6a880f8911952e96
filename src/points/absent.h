// SPDX-License-Identifier: Apache-2.0
// Sites that are not stored, where their value is not that of the base of a field.
#pragma once

#include "points/brick.h"
#include "points/sample_source.h"

namespace bccsplat {

// Gives the sites of `region` that are not kept this value, like kept ones.
void fill_absent(BrickLayer& layer, const BrickBox& region, float value);

} // namespace bccsplat
