// SPDX-License-Identifier: Apache-2.0
// What is along rays as lines of text, as CSV, or as JSON.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "tool/json_fwd.h"
#include "tool/output/output_file.h"
#include "tool/probe/rays.h"

namespace bcc4 {

// A line for each place: time, number of the ray from 1, distance, x, y, z, value, and of what is looked for
// the gradient.
class RayTable {
 public:
  // Columns between commas below a line of titles, into a file, or between tabs onto the terminal.
  RayTable(std::string path, bool overwrite, bool dated, bool picks);
  void add(double time, const std::string& date, std::span<const RayPlace> places);
  void finish();

 private:
  void write(const std::vector<std::string>& columns);

  std::unique_ptr<OutputFile> file_; // none: the terminal
  bool picks_;
};

[[nodiscard]] Json place_json(double time, const std::string& date, const RayPlace& place, bool picks);

} // namespace bcc4
