// SPDX-License-Identifier: Apache-2.0
// Where a file says whether the values of a channel are labels: an attribute of its name.
#pragma once

#include <optional>
#include <string>

#include "formats/bcc4/info.h"

namespace bccsplat {

[[nodiscard]] inline std::string labels_attribute(const std::string& channel) { return "labels." + channel; }

// None: the file does not say it.
[[nodiscard]] inline std::optional<bool> said_labels(const VolumeInfo& info, const std::string& channel) {
  for (const auto& [key, value] : info.attributes)
    if (key == labels_attribute(channel) && (value == "yes" || value == "no")) return value == "yes";
  return std::nullopt;
}

} // namespace bccsplat
