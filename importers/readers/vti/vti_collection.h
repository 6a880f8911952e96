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

// Returns the files in the order of their times, one for each; data sets without a time stay in order where
// --dt or --times give one. Throws for parts of a frame in several files, and for files elsewhere than below
// the collection's own folder.
[[nodiscard]] std::vector<CollectionEntry> read_collection(const std::string& path,
                                                           const ReaderOptions& options);

} // namespace bcc4
