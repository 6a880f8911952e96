// SPDX-License-Identifier: Apache-2.0
// VTK ImageData series: numbered .vti files, or a .pvd collection that names files and times.
#pragma once

#include <memory>

#include "readers/frame_reader.h"
#include "readers/reader_options.h"
#include "readers/sequence.h"

namespace bcc4 {

// Times are the TimeValue of the files, or the timesteps of the collection. --channel names arrays; without
// it the active scalars or the only array is read.
[[nodiscard]] std::unique_ptr<FrameReader> open_vti(const Sequence& sequence, const ReaderOptions& options);

} // namespace bcc4
