// SPDX-License-Identifier: Apache-2.0
// TIFF: stacks of pages, hyperstacks of ImageJ and OME-TIFF, and numbered files of them.
#pragma once

#include <memory>

#include "readers/frame_reader.h"
#include "readers/reader_options.h"
#include "readers/sequence.h"

namespace bcc4 {

[[nodiscard]] std::unique_ptr<FrameReader> open_tiff(const Sequence& sequence, const ReaderOptions& options);

} // namespace bcc4
