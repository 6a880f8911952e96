// SPDX-License-Identifier: Apache-2.0
// The XML around the values of a VTK ImageData file, and that of a collection of them.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tool/output/volume_file.h"

namespace bcc4 {

struct VtiText {
  std::string head, tail; // before and behind the values, which are appended as they are
};
[[nodiscard]] VtiText vti_text(const VolumeOutput& output);

// A .pvd: files, named from its own folder, and their times.
[[nodiscard]] std::string collection_text(const std::vector<std::pair<std::string, double>>& files);

} // namespace bcc4
