// SPDX-License-Identifier: Apache-2.0
// NRRD series: one file of three or four axes, or one file per frame.
#pragma once

#include <memory>

#include "readers/frame_reader.h"
#include "readers/reader_options.h"
#include "readers/sequence.h"

namespace bcc4 {

// The time axis is the one of kind "time", else the one of kind "list", else the one labelled t or time;
// never one picked by its place. Four axes without any such word are refused unless --axes names them.
[[nodiscard]] std::unique_ptr<FrameReader> open_nrrd(const Sequence& sequence, const ReaderOptions& options);

} // namespace bcc4
