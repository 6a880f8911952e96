// SPDX-License-Identifier: Apache-2.0
// What import is about to do, in words and as JSON.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tool/import/plan_series.h"
#include "tool/import/turn.h"

namespace bcc4 {

// Extrapolated from a stretch of frames that went through the real writer, into nothing.
struct ImportEstimate {
  uint64_t sites = 0; // lattice sites, all channels; exact
  uint64_t sampled_frames = 0;
  double bytes_file = 0;
  double bytes_memory = 0; // data of the library and frames of the reader
  double seconds = 0;
  std::vector<bccsplat_error_report> errors; // by channel, of the sampled frames
};

// What a dry run finds out besides.
struct DryRun {
  std::optional<ImportEstimate> estimate{};
  std::optional<Turn> turn{};
  std::array<std::optional<Turn>, 2> round{}; // the same of x and y
};

[[nodiscard]] uint64_t cc_samples(const SeriesDescription& series); // all channels
// "0 to 98 s, 99 frames, step 1".
[[nodiscard]] std::string times_text(const SeriesTimes& times);

void print_plan(const ImportPlan& plan, const DryRun& run = {});
[[nodiscard]] Json plan_json(const ImportPlan& plan, const DryRun& run = {});

} // namespace bcc4
