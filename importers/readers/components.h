// The components of a sample that become channels.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "readers/reader_options.h"

namespace bcc4 {

// All of `count` components, or those that --channel names by number or as c0, c1 ... Throws for more than 16
// without a choice.
[[nodiscard]] std::vector<uint64_t> wanted_components(const ReaderOptions& options, const std::string& path,
                                                      uint64_t count);

} // namespace bcc4
