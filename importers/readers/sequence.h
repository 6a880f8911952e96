// SPDX-License-Identifier: Apache-2.0
// Turns the inputs of the command line into the files of a series, sorted by frame number.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "readers/name_numbers.h"
#include "readers/reader_options.h"

namespace bcc4 {

struct Sequence {
  std::vector<SequenceFile> files; // rising numbers
  bool numbered = false;           // numbers come from the names; else they count the files
  NameOrder order = NameOrder::given;
  int64_t natural_stride = 1;   // greatest common divisor of the distances of all numbers found
  int64_t stride = 1;           // of the frames taken: the natural one or the selection's step
  std::vector<int64_t> missing; // numbers of the stride that no file has
  std::string note;             // how the files were found
};

// An input is a file, a pattern (smoke.%04d.vdb, smoke.####.vdb), a glob in the last part of the path, or
// @LIST, a text file with one path a line. Numbers are the digits in which the names differ; where these are
// decimals or several numbers, files are put in their order and counted. Files that the selection leaves out
// are not looked at. An empty result, a number twice, or names without order in a glob are errors.
[[nodiscard]] Sequence find_sequence(const std::vector<std::string>& inputs, const FrameSelection& selection);

// Throws for a file of a sequence whose `what` is not that of the first one.
[[noreturn]] void refuse_unlike(const Sequence& sequence, size_t file, const std::string& what);

// Returns text such as "3, 7-9 and 12": the numbers as ranges of the stride.
[[nodiscard]] std::string range_text(const std::vector<int64_t>& numbers, int64_t stride);

// These tell whether `name` holds a frame pattern, and replace it by a number, padded as asked for.
[[nodiscard]] bool has_frame_pattern(const std::string& name);
[[nodiscard]] std::string apply_frame_pattern(const std::string& name, int64_t number);

} // namespace bcc4
