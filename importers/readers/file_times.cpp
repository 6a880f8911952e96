// SPDX-License-Identifier: Apache-2.0
#include "readers/file_times.h"

#include <algorithm>
#include <cmath>

#include "readers/text.h"

namespace bcc4 {

void take_file_times(SeriesDescription& series, std::span<const FileTime> files, const std::string& key) {
  std::vector<double> times;
  for (const FileTime& f : files)
    if (f.time && std::isfinite(*f.time)) times.push_back(*f.time);
  if (times.empty()) return;
  if (times.size() < files.size()) {
    series.notes.push_back(
        concat("\"", key, "\" is told by ", times.size(), " of ", files.size(), " only, and not taken"));
    return;
  }
  const auto other = [&](const FileTime& f) { return !f.unit.empty() && f.unit != files.front().unit; };
  if (std::any_of(files.begin(), files.end(), other)) {
    series.notes.push_back(concat("\"", key, "\" of the files is in different units, and is not taken"));
    return;
  }
  const auto falls = [](double a, double b) { return !(a < b); };
  if (std::adjacent_find(times.begin(), times.end(), falls) != times.end()) {
    series.notes.push_back(concat("\"", key, "\" of the files does not rise, and is not taken"));
    return;
  }
  series.times = {std::move(times), files.front().unit,
                  concat("\"", key, files.size() > 1 ? "\" of each file" : "\" of the file")};
}

} // namespace bcc4
