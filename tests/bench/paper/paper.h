// SPDX-License-Identifier: Apache-2.0
// Suite `paper`: tables 1 and 3 of Neophytou & Mueller 2002 again, on real sets and on generated smoke, and
// what else its text claims in numbers.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "field/slice.h"
#include "tests/bench/fit/fit_source.h"
#include "tests/bench/report.h"

namespace bccsplat::bench {

//   paper [--data DIR] [--set NAME]: a folder with the sets named in paper_sets.cpp; those that are not there
//   are left out. One of them alone, or `smoke`; else the tables of the sets and all others:
//           --slicing [d4star|cc]  slices by its methods; one lattice alone, once, for counts of instructions
//           --phantom --band --shift --pipeline  one of these alone
// Returns the exit status; throws Error on wrong arguments.
int run_paper_suite(std::span<const std::string> args, const Report& report);

// Slices by the paper's methods, CC and D4* in turn. only_lattice: `cc` or `d4star` alone, once, untimed.
void report_slicing(const Report& report, const std::string& only_lattice);
// A phantom reconstructed on CC, on BCC and resampled.
void report_phantom(const Report& report);
// The ball of frequencies, the 24-cell around it and the cube; and what series have in each.
void report_band(const Report& report);
void report_energy(const Report& report, const std::vector<FitSource>& series);
// What smoothing does to pictures of volumes.
void report_shift(const Report& report, const std::vector<FitSource>& volumes);
// Bytes of the run lengths of a slice's points, row after row of each coset.
[[nodiscard]] uint64_t slice_runs(const Slice& slice);

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
