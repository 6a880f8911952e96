// SPDX-License-Identifier: Apache-2.0
// A file whose series goes on. It is opened once, as `old`, and let go of before it is written: some systems
// replace no file that is open.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tool/handles.h"
#include "tool/import/plan_file.h"
#include "tool/import/plan_series.h"

namespace bcc4 {

struct AppendedFile {
  uint64_t frames = 0;
  std::vector<PlannedSource> sources;
  std::vector<std::pair<std::string, std::string>> attributes; // that stay where they are not set anew
};
// filtering: how frames become layers, as the attribute import.filtering tells. Refuses a file whose frames
// were filtered in another way, or that has other times, places, units, samples per frame or more frames than
// the series.
[[nodiscard]] AppendedFile read_appended(const Volume& old, const std::string& path,
                                         const SeriesDescription& series, const std::string& filtering);

// The one channel of a series goes on under the name that it has in the file, which is said; and samples of
// which the input says no place stay where they are.
[[nodiscard]] std::unique_ptr<FrameReader> continue_series(const Volume& old, const std::string& path,
                                                           std::unique_ptr<FrameReader> reader);

// Refuses ends and faces that are asked for, but are others than the file has.
void refuse_other_ends(const Device& device, const Volume& old, const std::string& path,
                       const WriterSettings& settings);
// A series that is appended to keeps its lattice, steps that are not those of the source, and the error that
// it promises, or that its wavelets have.
void adopt_lattice(const Device& device, const Volume& old, WriterSettings& settings, PlanWish& wish);
void adopt_error(const Volume& old, WriterSettings& settings);
void adopt_steps(const Volume& old, const SeriesDescription& series, WriterSettings& settings);

} // namespace bcc4
