// SPDX-License-Identifier: Apache-2.0
// What the histogram of a channel says about it: which values are air and noise, which an object, and of what
// kind the values are.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "points/values.h"
#include "series/data_kind.h"

namespace bccsplat {

// Counts of a channel's samples, and what else its file says of them.
struct ValueCounts {
  std::vector<uint64_t> bins; // of the stored samples, over `stored`, the last one closed
  Range stored;
  Range source;                 // of the source's values; what lies beyond is ringing
  double air = 0;               // of the sites that are not stored
  uint64_t air_sites = 0;       // how many these are
  bool integers = false;        // the source is of whole numbers
  bool exact = true;            // and the samples are not coded in steps that skip some of them
  double rounding = 0;          // how far a sample may be from its whole number, by finer steps beside these
  bool incomplete = false;      // some of the domain is missing
  bool level_set = false;       // values are known to be distances, negative inside
  std::optional<bool> labels{}; // the file says whether values are labels
  double voxels = 1;            // of a frame
  series::DataKind data{};      // what they are of
};

enum class ValueKind : uint8_t { empty, constant, labels, level_set, both_signs, solid, fog, dense };

// What is on one side of the empty values.
struct SideOfValues {
  double mean = 0;  // distance from the background
  double share = 0; // of all that is not empty
};

struct ValueSurvey {
  ValueKind kind = ValueKind::empty;
  series::DataKind data{}; // as counted
  // Values between are air and noise; infinite where nothing but these is beyond; low > high: none are.
  Range empty{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  bool below = false, above = false; // on which sides of the empty values there are others
  Range colors{0, 1};                // what is not empty, but for the last few per mille on either side
  double background = 0;             // the value that empty space has
  double object = 0;                 // of a solid: the first value where its samples pile up
  double mean = 0;                   // of what is not empty, as distance from the background
  double noise = 0;    // of a solid: standard deviation of the values of which most is made; 0: not seen
  double boundary = 0; // between background and object
  // The surface that is drawn where nobody asks for a value: the boundary, or where an object's values go on
  // down to the noise, and a surface between the two would be torn, one inside the object.
  double surface = std::numeric_limits<double>::quiet_NaN();
  double crossing = 1;       // voxels along a ray through the middle of what is not empty
  SideOfValues lower, upper; // what is below the background, and what is above it
  // Rising, without the background, which air is where it lies below them. Where the range has more than 256
  // whole numbers, all that the samples of a bin may be.
  std::vector<double> labels;
};

// as: what the values are taken for, whatever they look like: both_signs, labels (none found: no list of
// them), or with any other kind quantities, which labels are not.
[[nodiscard]] ValueSurvey survey_values(const ValueCounts& counts,
                                        std::optional<ValueKind> as = std::nullopt);

// Returns the survey of a part of the channel, by the counts of the part: its colours and what its means are
// told by are the part's, air and noise those of the whole. Where nothing is seen of the part, and where
// values are no quantities of one sign, it is the survey of the whole.
[[nodiscard]] ValueSurvey survey_part(const ValueSurvey& whole, const ValueCounts& part);

// Returns the value that divides the samples in [low, high] into two classes that differ most (Otsu 1979).
[[nodiscard]] double otsu_threshold(const std::vector<double>& bins, const Range& range, double low);

} // namespace bccsplat
