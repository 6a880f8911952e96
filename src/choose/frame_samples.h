// SPDX-License-Identifier: Apache-2.0
// What a file has at the samples of its source.
#pragma once

#include <cstdint>
#include <span>

#include "series/library.h"

namespace bccsplat::series {

// Fills `values` with a box of a frame, x fastest. token: may be null.
void sample_frame(const Volume& volume, uint64_t frame, uint32_t channel, const SampleBox& box,
                  bccsplat_cancel_token* token, std::span<float> values);

} // namespace bccsplat::series
