// SPDX-License-Identifier: Apache-2.0
// Files packed with gzip whose format has no gzip of its own: they are unpacked into a folder for temporary
// files while they are read.
#pragma once

#include <functional>
#include <memory>

#include "readers/frame_reader.h"
#include "readers/sequence.h"

namespace bcc4 {

// Unpacks the files of a sequence and opens them by `open`. The description, names of frames and errors have
// the names of the packed files. What is unpacked goes with the reader.
[[nodiscard]] std::unique_ptr<FrameReader>
open_unpacked(const Sequence& sequence,
              const std::function<std::unique_ptr<FrameReader>(const Sequence& sequence)>& open);

} // namespace bcc4
