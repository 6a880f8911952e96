// SPDX-License-Identifier: Apache-2.0
// What a .bcc4 file tells of itself, for files of other formats.
#pragma once

#include "tool/handles.h"
#include "tool/output/volume_file.h"

namespace bcc4 {

// Returns names, units, the space, the date of time 0 and its calendar; sizes, place and times are left open.
[[nodiscard]] VolumeOutput describe_volume(const Volume& volume, uint32_t channel);

} // namespace bcc4
