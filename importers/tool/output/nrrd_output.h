// SPDX-License-Identifier: Apache-2.0
// Header text of attached NRRD files with raw little-endian data.
#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "readers/affine.h"
#include "readers/value_type.h"

namespace bcc4 {

struct NrrdOutput {
  Type type = Type::f32;
  std::vector<uint64_t> sizes; // x, y, z and perhaps t
  Affine affine{};             // index -> world
  std::string content;         // the name of the channel
  std::string sample_unit;     // of its values
  std::string space;           // "" : three unnamed dimensions
  std::string spatial_unit, time_unit;
  std::vector<double> times; // of a fourth axis
  // Coordinates of the samples along x, y and z, and their units; empty: as the affine says.
  std::array<std::vector<double>, 3> coordinates{};
  std::array<std::string, 3> coordinate_units{};
  std::array<bool, 3> coordinates_down{};
  std::vector<std::pair<std::string, std::string>> keys;
};

// The keys that tell the time of a single frame, for which the format has no field; the reader takes them.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> time_keys(double time,
                                                                         const std::string& unit);
// Ends with the empty line after which the data begin.
[[nodiscard]] std::string nrrd_header_text(const NrrdOutput& output);

} // namespace bcc4
