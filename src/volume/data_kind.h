// SPDX-License-Identifier: Apache-2.0
// The kind of data that a channel of a file is of.
#pragma once

#include "series/data_kind.h"
#include "volume/open_volume.h"
#include "volume/value_counts.h"

namespace bccsplat {

// Returns the kind that the file says, else the one that is found by its places and units and the channel's
// values.
[[nodiscard]] series::DataKind kind_of_data(const VolumeInfo& volume, const ChannelInfo& channel,
                                            const ValueCounts& counts);

// Returns the value that the attribute `key` would have in a file that leaves it out, where it is that of a
// channel's kind, and one is found; else null.
[[nodiscard]] const char* found_kind(const OpenVolume& volume, std::string_view key);

} // namespace bccsplat
