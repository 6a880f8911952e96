// SPDX-License-Identifier: Apache-2.0
// What can be said to bcc4 import: its options, and what they mean for the writer.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "tool/import/reader_arguments.h"
#include "tool/import/resume.h"
#include "tool/import/write_series.h"
#include "tool/options.h"

namespace bcc4 {

struct ImportArguments {
  ReaderArguments reader;
  WriterSettings settings;
  CommonOptions common;
  std::optional<double> air, air_threshold, abs, psnr;
  std::string scale;      // a number, or one for each axis
  std::string time_scale; // a number, or auto
  std::string lattice;    // a name, or auto
  std::string levels;     // a number, auto or none; empty: auto
  std::optional<double> density;
  bool exact = false, lowpass = false, overwrite = false;
  int32_t periodic = 0, quantize = BCCSPLAT_TYPE_DEFAULT;
  std::string kernel;
  std::string output;
  bool dry_run = false;
  std::string plan, part, block; // file; frames and samples as typed
  bool blocks = false;
  ResumeArguments resume;
  ImportArguments() { settings.measure = BCCSPLAT_MEASURE_SOME; }
  [[nodiscard]] bool follows_plan() const { return !plan.empty() && !dry_run; }
  [[nodiscard]] bool auto_levels() const { return levels.empty() || levels == "auto"; }
};

void add_import_options(const Command& import, ImportArguments& arguments);

// Says before the work what cannot be written.
void check_outputs(const ImportArguments& arguments);
// Checks what was typed about the writer and completes its settings.
void read_settings(ImportArguments& arguments);
// The settings of the channels of a series.
[[nodiscard]] std::vector<bccsplat_channel_options> read_channels(const ImportArguments& arguments,
                                                                  const SeriesDescription& series);
// Is the lattice, or its shape, to be chosen?
[[nodiscard]] bool chooses_lattice(const ImportArguments& arguments);

} // namespace bcc4
