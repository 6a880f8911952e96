// SPDX-License-Identifier: Apache-2.0
// A dense box of values -> an OpenVDB file.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>

#include "readers/affine.h"
#include "readers/vdb/vdb_metadata.h"

namespace bcc4 {

struct VdbOutput {
  std::string grid;                      // its name
  std::string grid_class = "fog volume"; // in small letters
  std::array<uint64_t, 3> dims{};
  std::array<int32_t, 3> begin{}; // the grid's index of the first voxel
  Affine affine{};                // of the box, whose first voxel is (0, 0, 0), to the world
  float air = 0;                  // the background; of level sets that outside
  float least = 0; // voxels that differ by less from the background stay inactive, and so do equal ones
  std::array<float, 2> range; // values beyond are written as its ends
  bool as_half = false, as_double = false;
  bool all_active = false; // whatever their values
  VdbTold told{};          // time and units, as metadata
  bool overwrite = false;
};

[[nodiscard]] inline bool is_level_set(const VdbOutput& output) { return output.grid_class == "level set"; }
// Returns how far the value is from the background, for a level set from either of them; NaN is not.
[[nodiscard]] inline float distance_from_air(const VdbOutput& output, float value) {
  if (std::isnan(value)) return 0;
  return is_level_set(output) ? output.air - std::fabs(value) : std::fabs(value - output.air);
}
// The least distance at which no more than `count` of the values of a frame are active, but for equal ones.
[[nodiscard]] float least_distance(const VdbOutput& output, std::span<const float> values, uint64_t count);

// x fastest.
void write_vdb(const std::string& path, const VdbOutput& output, std::span<const float> values);

} // namespace bcc4
