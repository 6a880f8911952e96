// SPDX-License-Identifier: Apache-2.0
#include "readers/components.h"

#include <algorithm>

#include "readers/error.h"

namespace bcc4 {

namespace {

// Returns the number of a component that --channel names.
uint64_t component_number(const std::string& name, const std::string& path, uint64_t count,
                          std::span<const std::string> names) {
  const auto named = std::find(names.begin(), names.end(), name);
  if (named != names.end()) return static_cast<uint64_t>(named - names.begin());
  const auto c = parse_number<uint64_t>(name.starts_with('c') ? std::string_view(name).substr(1) : name);
  if (c && *c < count) return *c;
  fail_usage("--channel ", name, ": ", path, " has channels ",
             names.empty() ? concat("c0 to c", count - 1) : join(names));
}

std::vector<uint64_t> wanted_components(const ReaderOptions& options, const std::string& path, uint64_t count,
                                        std::span<const std::string> names) {
  constexpr uint64_t limit = 16;
  std::vector<uint64_t> wanted;
  if (options.channels.empty()) {
    if (count > limit) fail_usage(path, ": ", count, " values per sample: choose with --channel 0,1,2");
    for (uint64_t c = 0; c < count; ++c) wanted.push_back(c);
    return wanted;
  }
  for (const std::string& name : options.channels)
    wanted.push_back(component_number(name, path, count, names));
  return wanted;
}

} // namespace

std::vector<uint64_t> add_channels(SeriesDescription& d, const ReaderOptions& options,
                                   const std::string& path, uint64_t count, const Channel& kind,
                                   std::span<const std::string> names) {
  if (count == 1) refuse_channel_option(options, path, d.format.c_str());
  std::vector<uint64_t> wanted = wanted_components(options, path, count, names);
  for (const uint64_t c : wanted) {
    d.channels.push_back(kind);
    if (count > 1) d.channels.back().name = names.empty() ? concat("c", c) : names[c];
  }
  return wanted;
}

} // namespace bcc4
