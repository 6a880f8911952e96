// SPDX-License-Identifier: Apache-2.0
// What corrections add to the ranges that bricks and cells of points are left out by.
#pragma once

#include "splat/points/points.h"

namespace bccsplat {

// Widens the ranges of the slice's points by its corrections near them. The codes of single points say
// nothing then and are dropped.
void widen_by_corrections(const Slice& slice, SplatPoints& points);

} // namespace bccsplat
