// SPDX-License-Identifier: Apache-2.0
#include "readers/components.h"

#include "readers/error.h"

namespace bcc4 {

namespace {

std::vector<uint64_t> wanted_components(const ReaderOptions& options, const std::string& path,
                                        uint64_t count) {
  constexpr uint64_t limit = 16;
  std::vector<uint64_t> wanted;
  if (options.channels.empty()) {
    if (count > limit) fail_usage(path, ": ", count, " values per sample: choose with --channel 0,1,2");
    for (uint64_t c = 0; c < count; ++c) wanted.push_back(c);
    return wanted;
  }
  for (const std::string& name : options.channels) {
    const auto c = parse_number<uint64_t>(name.starts_with('c') ? std::string_view(name).substr(1) : name);
    if (!c || *c >= count) fail_usage("--channel ", name, ": ", path, " has channels c0 to c", count - 1);
    wanted.push_back(*c);
  }
  return wanted;
}

} // namespace

std::vector<uint64_t> add_channels(SeriesDescription& d, const ReaderOptions& options,
                                   const std::string& path, uint64_t count, const Channel& kind) {
  if (count == 1) refuse_channel_option(options, path, d.format.c_str());
  std::vector<uint64_t> wanted = wanted_components(options, path, count);
  for (const uint64_t c : wanted) {
    d.channels.push_back(kind);
    if (count > 1) d.channels.back().name = concat("c", c);
  }
  return wanted;
}

} // namespace bcc4
