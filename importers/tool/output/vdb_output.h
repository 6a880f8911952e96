// SPDX-License-Identifier: Apache-2.0
// A dense box of values -> an OpenVDB grid. Only the vdb files know OpenVDB.
#pragma once

#include <span>
#include <string>

#include "readers/affine.h"

namespace bcc4 {

struct VdbOutput {
  std::string grid; // its name
  std::string grid_class = "fog volume";
  std::array<uint64_t, 3> dims{};
  Affine affine{}; // index -> world
  float air = 0;   // the background; of level sets that outside
  float least = 0; // voxels that differ by less from the background stay inactive, and so do equal ones
  std::array<float, 2> range; // values beyond are written as its ends
  bool as_half = false;
  double time = 0; // kept as metadata "time"
  bool overwrite = false;
};

// Returns how far the value is from the background, for a level set from either of them; NaN is not.
[[nodiscard]] float distance_from_air(const VdbOutput& output, float value);
// The least distance at which no more than `count` of the values of a frame are active, but for equal ones.
[[nodiscard]] float least_distance(const VdbOutput& output, std::span<const float> values, uint64_t count);

// x fastest.
void write_vdb(const std::string& path, const VdbOutput& output, std::span<const float> values);

} // namespace bcc4
