// SPDX-License-Identifier: Apache-2.0
// The values of a frame at the source's samples.
#pragma once

#include "base/context.h"
#include "base/vec.h"
#include "volume/open_volume.h"

namespace bccsplat {

// Source samples of a frame, from begin to before end.
struct SampleBox {
  Int3 begin{}, end{};
};

// Fills `values`, x fastest; NaN where nothing is. The frame and the box are inside the series. Reads no
// more than the box where the field goes through its samples; else it cuts a slice of the box.
void read_frame(const OpenVolume& volume, uint32_t channel, int64_t frame, const SampleBox& box,
                float* values, const Context& context);

} // namespace bccsplat
