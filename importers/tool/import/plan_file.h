// SPDX-License-Identifier: Apache-2.0
// What a dry run decides about a series, in a file: several processes import parts of it alike.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "readers/frame_reader.h"
#include "tool/import/plan_series.h"
#include "tool/options.h"

namespace bcc4 {

struct PlannedSource {
  std::string name; // without its folder
  uint64_t bytes = 0;
  uint32_t crc32 = 0; // 0: not known
  bool operator==(const PlannedSource&) const = default;
};

struct PlanFile { // NOLINT(bugprone-exception-escape): moving a Json asserts, and throws nothing
  std::vector<std::string> inputs;
  std::vector<std::pair<std::string, std::string>> options; // of the reader, as typed, without the dashes
  std::vector<WriterSettings> attempts;                     // one, and where it misses a PSNR the next
  Json found;                                               // of the series, as the library tells it
  // The series as it was read: what must be found again.
  std::array<uint64_t, 4> dims{};
  std::vector<double> times;
  std::vector<std::string> channels;
  std::vector<PlannedSource> sources;
};

// A plan is followed from any folder: its inputs, and a file of times among its options, by absolute paths.
void make_absolute(PlanFile& plan);
void write_plan_file(const std::string& path, const PlanFile& plan, bool overwrite);
[[nodiscard]] PlanFile read_plan_file(const std::string& path);
// Returns what a plan says of settings: those that decide what is written.
[[nodiscard]] std::string settings_text(const WriterSettings& settings);
// Refuses a series that is not the planned one.
void check_planned(const PlanFile& plan, const std::string& path, const SeriesDescription& series);

} // namespace bcc4
