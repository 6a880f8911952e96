// SPDX-License-Identifier: Apache-2.0
// Which page of a TIFF file is which channel, plane and moment.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "readers/file_times.h"
#include "readers/tiff/tiff_file.h"

namespace bcc4 {

// Pages as ImageJ or OME-XML name them; of files that say nothing all are planes along z.
struct TiffStack {
  std::string said_by{};                        // "ImageJ", "OME-XML", "tifffile" or ""
  uint64_t c = 1, z = 1, t = 1;                 // pages along channels, z and time
  std::string order = "czt";                    // the fastest first
  std::array<std::optional<double>, 3> steps{}; // of x, y and z
  std::string unit{};
  std::optional<double> interval{}; // of time
  std::string time_unit{};
  std::vector<FileTime> moments{};  // when each began, where that is told one by one
  std::vector<std::string> names{}; // of channels; empty: none
  std::vector<uint64_t> unnamed{};  // sizes of axes of pages that the file does not name, the fastest first

  // Takes axes of pages, c, z or t each once, with their sizes, the fastest first.
  void set_axes(const std::string& letters, const std::vector<uint64_t>& sizes);
  [[nodiscard]] uint64_t page(uint64_t channel, uint64_t plane, uint64_t moment) const;
};

// Returns how the pages of a file are meant. Fails where the file says that it has other pages than it has,
// and, where its steps are used, if they are in units that cannot be made one.
[[nodiscard]] TiffStack tiff_stack(const TiffFile& file, bool with_steps);

} // namespace bcc4
