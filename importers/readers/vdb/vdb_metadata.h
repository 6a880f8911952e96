// SPDX-License-Identifier: Apache-2.0
// What OpenVDB has no place for and grids tell as metadata of their own, written by export and read by
// import.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <utility>

namespace bcc4 {

struct VdbTold {
  std::optional<double> time; // "time", a double; other tools write floats and integers
  std::string time_unit;      // strings, left out where nothing is known
  std::string value_unit;
  std::string space_unit; // of the world that the transform leads to
};

// The names of the texts.
inline constexpr std::array<std::pair<const char*, std::string VdbTold::*>, 3> vdb_texts{
    {{"time_unit", &VdbTold::time_unit},
     {"value_unit", &VdbTold::value_unit},
     {"space_unit", &VdbTold::space_unit}}};

} // namespace bcc4
