// SPDX-License-Identifier: Apache-2.0
// What a file tells of the OpenVDB grid it was made of, for one that is written.
#pragma once

#include <span>

#include "tool/handles.h"
#include "tool/output/vdb_output.h"
#include "tool/view/slice_choice.h"

namespace bcc4 {

// Name, class, background, range and precision of a channel's source, and its units.
[[nodiscard]] VdbOutput vdb_like_source(const Volume& volume, uint32_t channel);
void tell_time(const Volume& volume, double time, VdbOutput& output);
// Leaves as many voxels active as the source had at that moment, where the file knows; `values` of the whole
// frame.
void keep_sparsity(const Volume& volume, uint32_t channel, double index, std::span<const float> values,
                   VdbOutput& output);

} // namespace bcc4
