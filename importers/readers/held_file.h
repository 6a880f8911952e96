// SPDX-License-Identifier: Apache-2.0
// A reader holds the file of the frame it was asked for last, for describing the series has opened the first
// one, and the channels of one frame share theirs.
#pragma once

#include <memory>
#include <string>

namespace bcc4 {

// Returns the file at `path`: the one that is held, or that file in its place.
template<class File> [[nodiscard]] File& hold_file(std::unique_ptr<File>& held, const std::string& path) {
  if (!held || held->path() != path) {
    held.reset(); // first: two files take the memory of two
    held = std::make_unique<File>(path);
  }
  return *held;
}

} // namespace bcc4
