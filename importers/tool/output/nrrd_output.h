// SPDX-License-Identifier: Apache-2.0
// Header text of attached NRRD files with raw little-endian data.
#pragma once

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
  std::string space;           // "" : three unnamed dimensions
  std::string spatial_unit, time_unit;
  std::vector<double> times; // of a fourth axis
  std::vector<std::pair<std::string, std::string>> keys;
};

// Ends with the empty line after which the data begin.
[[nodiscard]] std::string nrrd_header_text(const NrrdOutput& output);

} // namespace bcc4
