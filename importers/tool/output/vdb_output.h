// A dense box of values -> an OpenVDB fog volume. Only the vdb files know OpenVDB.
#pragma once

#include <span>
#include <string>

#include "readers/affine.h"

namespace bcc4 {

struct VdbOutput {
  std::string grid; // its name
  std::array<uint64_t, 3> dims{};
  Affine affine{}; // index -> world
  float air = 0;   // the background: equal values and NaN stay inactive
  double time = 0; // kept as metadata "time"
  bool overwrite = false;
};

// x fastest.
void write_vdb(const std::string& path, const VdbOutput& output, std::span<const float> values);

} // namespace bcc4
