// SPDX-License-Identifier: Apache-2.0
// A collection of VTK files with their times (.pvd), as ParaView writes it.
#pragma once

#include <string>
#include <vector>

#include "readers/reader_options.h"

namespace bcc4 {

struct CollectionEntry {
  double time = 0;
  std::string path;
};

struct Collection {
  std::vector<CollectionEntry> entries; // in the order of their times
  bool timed = true;                    // all have times; else these count them
  std::string note{};                   // what was left out
};

// Returns one file for each time; of a run that was taken up again at an earlier time what it wrote from
// there on. Data sets without a time, or of one time, stay in order where --dt or --times give one. Throws
// for parts of a frame in several files, and for files elsewhere than below the collection's own folder.
[[nodiscard]] Collection read_collection(const std::string& path, const ReaderOptions& options);

} // namespace bcc4
