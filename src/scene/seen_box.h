// SPDX-License-Identifier: Apache-2.0
// Where in the world there is something to be seen of a slice.
#pragma once

#include "field/slice.h"
#include "shade/transfer_function.h"
#include "view/camera.h"

namespace bccsplat {

// Returns a box of the world around what the function shows of the slice: that of its whole domain where it
// shows nothing, or the values that no coefficient reaches. Specks that are a few in a thousand of what is
// seen do not count.
[[nodiscard]] WorldBox seen_box(const Slice& slice, const TransferFunction& function);

} // namespace bccsplat
