// SPDX-License-Identifier: Apache-2.0
// What `bcc4 import` makes of a source, as somebody who has it as raw samples runs it.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "tests/bench/fit/fit_source.h"

namespace bccsplat::bench {

// Whether the tool was built with the benchmark; without it importing fails.
[[nodiscard]] bool has_tool();

// A folder with the samples of a source, and with the file made of them last; it goes with its object.
class ToolImport {
 public:
  explicit ToolImport(const FitSource& source);
  ~ToolImport();
  ToolImport(const ToolImport&) = delete;
  ToolImport& operator=(const ToolImport&) = delete;

  // Runs the tool with these options and every frame measured; its report, which is JSON.
  [[nodiscard]] std::string run(const std::string& options) const;
  // The same without a report, and what is measured as the options say: CPU seconds of the tool, on one
  // thread.
  [[nodiscard]] double seconds(const std::string& options) const;
  // Reads every frame of the file back, packed as the source is; CPU seconds of the tool on one thread, the
  // system's not among them.
  [[nodiscard]] double export_seconds(std::vector<std::byte>& frames) const;
  [[nodiscard]] std::string file() const { return folder_ + "/out.bcc4"; }

 private:
  std::string folder_, arguments_;
};

} // namespace bccsplat::bench
