// SPDX-License-Identifier: Apache-2.0
// What fills a series that the suite `moments` makes.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "base/vec.h"

namespace bccsplat::bench {

enum class Content {
  waves,          // 12 plane waves of 8 to 60 voxels that move
  marschner_lobb, // the test signal of that name
  turbulence,     // folds where 60 waves of 6 to 120 voxels change sign, their octaves alike
  thin_shells,    // shells 2 voxels thick, 24 apart, that shrink
  vessel          // a bright curved line, 1.4 voxels thick, in a smooth field
};
inline constexpr int contents = 5;

[[nodiscard]] std::string name_of(Content content);
// n^3 values of 0 to 255, a little beyond at times, at a frame t.
[[nodiscard]] std::vector<float> content_values(Content content, size_t n, double t);
// The waves between voxels and frames, and their gradient per voxel unless null.
[[nodiscard]] double waves_at(const Vec3& p, double t, Vec3* gradient);

} // namespace bccsplat::bench
