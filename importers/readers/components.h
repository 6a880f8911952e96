// SPDX-License-Identifier: Apache-2.0
// The components of a sample that become channels.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "readers/frame_reader.h"
#include "readers/reader_options.h"

namespace bcc4 {

// Adds a channel like `kind` for each of `count` components, or for those that --channel names by number or
// as c0, c1 ..., and returns their numbers. Where components have names, such as red, these are the channels'
// and --channel takes them, too. Throws for more than 16 without a choice, and for a choice where there is
// but one component.
std::vector<uint64_t> add_channels(SeriesDescription& d, const ReaderOptions& options,
                                   const std::string& path, uint64_t count, const Channel& kind,
                                   std::span<const std::string> names = {});

} // namespace bcc4
