// SPDX-License-Identifier: Apache-2.0
// A file whose series goes on.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "choose/series_writer.h"
#include "tool/handles.h"
#include "tool/import/plan_file.h"

namespace bcc4 {

struct AppendedFile {
  uint64_t frames = 0;
  std::vector<PlannedSource> sources;
  std::vector<std::pair<std::string, std::string>> attributes; // that stay where they are not set anew
};
// filtering: how frames become layers, as the attribute import.filtering tells. Refuses a file whose frames
// were filtered in another way, or that has other times, places, units, samples per frame or more frames than
// the series.
[[nodiscard]] AppendedFile open_appended(const Device& device, const std::string& path,
                                         const SeriesDescription& series, const std::string& filtering);

// The one channel of a series goes on under the name that it has in the file, which is said; and samples of
// which the input says no place stay where they are.
[[nodiscard]] std::unique_ptr<FrameReader> continue_series(const Device& device, const std::string& path,
                                                           std::unique_ptr<FrameReader> reader);

// Refuses ends and faces that are asked for, but are others than the file has.
void refuse_other_ends(const Device& device, const std::string& path, const WriterSettings& settings);
// Returns whether it was made in blocks, whose predictions its new frames have then, too.
[[nodiscard]] bool predictions_are_fixed(const Device& device, const std::string& path);
// Returns how many coarser levels it has, which it keeps.
[[nodiscard]] uint32_t levels_in_file(const Device& device, const std::string& path);
// A series that is appended to keeps its lattice, steps that are not those of the source, and the error that
// it promises, or that its wavelets have.
void adopt_lattice(const Device& device, const std::string& path, WriterSettings& settings);
void adopt_error(const Device& device, const std::string& path, WriterSettings& settings);
void adopt_steps(const Device& device, const std::string& path, const SeriesDescription& series,
                 WriterSettings& settings);

} // namespace bcc4
