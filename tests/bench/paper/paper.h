// SPDX-License-Identifier: Apache-2.0
// Suite `paper`: tables 1 and 3 of Neophytou & Mueller 2002 again, on real sets and on generated smoke.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>

#include "tests/bench/fit/fit_source.h"
#include "tests/bench/report.h"

namespace bccsplat::bench {

//   paper [--data DIR] [--set NAME]: a folder with the sets named in paper_sets.cpp; those that are not there
//   are left out. One of them alone, or `smoke`
// Returns the exit status; throws Error on wrong arguments.
int run_paper_suite(std::span<const std::string> args, const Report& report);

struct PaperSet {
  const char* name;
  const char* file;
  const char* dims;    // x,y,z of raw files; else empty
  const char* channel; // of files with several; else empty
  bool series;         // 4D
};
[[nodiscard]] std::span<const PaperSet> paper_sets();
// Real 4D series of integers and floats, each a file: those that fits are measured on.
[[nodiscard]] std::span<const PaperSet> real_series();

// Its samples; none where the file, or the reader for it, is not there. What the reader marked as missing is
// 0.
[[nodiscard]] std::optional<FitSource> load_paper_set(const PaperSet& set, const std::string& folder);

} // namespace bccsplat::bench
