// SPDX-License-Identifier: Apache-2.0
// Raw arrays: one file for the series or one per frame, plain or gzip.
#pragma once

#include <memory>

#include "readers/frame_reader.h"
#include "readers/reader_options.h"
#include "readers/sequence.h"

namespace bcc4 {

// --dims and --dtype are needed. The sizes of the files must match them exactly.
[[nodiscard]] std::unique_ptr<FrameReader> open_raw(const Sequence& sequence, const ReaderOptions& options);

} // namespace bcc4
