// SPDX-License-Identifier: Apache-2.0
// OpenVDB series: one file per frame, fog volumes and level sets of scalar type.
#pragma once

#include <memory>
#include <string>

#include "readers/frame_reader.h"
#include "readers/reader_options.h"
#include "readers/sequence.h"

namespace bcc4 {

// The bounding boxes of the active voxels of all frames are united; transforms may differ by whole voxels.
// Inactive voxels are background (air); level sets keep the sign inside. Each --grid is a channel,
// empty in files that do not have it.
[[nodiscard]] std::unique_ptr<FrameReader> open_vdb(const Sequence& sequence, const ReaderOptions& options);

} // namespace bcc4
