// SPDX-License-Identifier: Apache-2.0
// Picks the reader for what the inputs are.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "readers/frame_reader.h"
#include "readers/reader_options.h"

namespace bcc4 {

// Finds the files and asks the reader that knows the first bytes of the first one; what no reader knows is
// raw and needs --dims and --dtype.
[[nodiscard]] std::unique_ptr<FrameReader> open_series(const ReaderOptions& options);

// Returns the name of the format whose files end as this path does, empty where none does. Raw files end in
// anything.
[[nodiscard]] std::string format_of_name(const std::string& path);

struct ReaderInfo {
  const char* name;
  bool present; // false: this build left it out
  std::string detail;
};
[[nodiscard]] std::vector<ReaderInfo> reader_list();

} // namespace bcc4
