// SPDX-License-Identifier: Apache-2.0
// MetaImage: .mha with the data inside, .mhd with data files beside it.
#pragma once

#include <memory>
#include <string_view>

#include "readers/frame_reader.h"
#include "readers/reader_options.h"
#include "readers/sequence.h"

namespace bcc4 {

// Returns whether the first bytes of a file look like a MetaImage header.
[[nodiscard]] bool is_metaimage(std::string_view start);

// The fourth axis is time, its ElementSpacing the time step, or the third one of pictures that have fields of
// their own (Seq_Frame0000_Timestamp: the times, in seconds); or one file per frame. Elements of several
// channels become channels c0, c1 ... Data: raw, zlib, or text; attached, in a file, a list or a numbered
// series of files.
[[nodiscard]] std::unique_ptr<FrameReader> open_metaimage(const Sequence& sequence,
                                                          const ReaderOptions& options);

} // namespace bcc4
