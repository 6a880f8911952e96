// SPDX-License-Identifier: Apache-2.0
// The numbers in the names of files, and the order that they make of a series.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace bcc4 {

struct SequenceFile {
  std::string path;
  int64_t number = 0;
  double decimal = 0; // of NameOrder::decimals
};

enum class NameOrder : uint8_t {
  given,    // names differ in more than numbers
  counter,  // a whole number counts frames
  decimals, // one number, with a point or an exponent: 0.5, 10.5; 1e-3, 5e-3
  tuple     // several numbers, read from left to right: 2023-07 .. 2024-06
};

// Puts files in the order of the numbers in which their names differ, and numbers them: by the counter, else
// from 0. Files whose numbers rise as a tuple stay in the order that they are in. Throws for a number twice.
NameOrder order_by_names(std::vector<SequenceFile>& files);

} // namespace bcc4
