// SPDX-License-Identifier: Apache-2.0
#include "tool/view/picture_shape.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "readers/text.h"

namespace bcc4 {
namespace {

constexpr double third_axis = 0.4; // of the mean of two axes that have one unit
constexpr double as_it_is = 1.5;   // factors that differ by no more are none

// What is given in the world as the file has it.
bool speaks_of_the_world(const RenderArguments& a) {
  return !a.clips.empty() || !a.view_matrix.empty() || !a.over.empty() ||
         lower(a.camera).ends_with(".json") || a.unit_distance;
}

std::array<double, 3> sides_of(const bccsplat_volume_info& v) {
  std::array<double, 3> sides{};
  for (size_t r = 0; r < 3; ++r)
    for (size_t c = 0; c < 3; ++c)
      sides[r] += std::fabs(v.affine[4 * r + c]) * static_cast<double>(v.dims[c]);
  return sides;
}

// Whether every axis of the samples lies along one of the world, as those of maps do.
bool along_the_world(const bccsplat_volume_info& v) {
  for (size_t r = 0; r < 3; ++r)
    for (size_t c = 0; c < 3; ++c)
      if (r != c && v.affine[4 * r + c] != 0) return false;
  return true;
}

void tell(const RenderArguments& a, const std::array<std::string, 3>& units,
          const std::array<double, 3>& sides, const std::array<double, 3>& shape) {
  std::string named, drawn;
  for (size_t i = 0; i < 3; ++i) {
    named += concat(i ? ", " : "", std::string(1, "xyz"[i]), " in ", units[i].empty() ? "?" : units[i]);
    drawn += concat(i ? " : " : "", short_number(sides[i] * shape[i], 3));
  }
  std::fprintf(stderr, "bcc4: %s: %s: drawn as a box of %s; --shape stored or SX,SY,SZ to change\n",
               a.file.c_str(), named.c_str(), drawn.c_str());
}

} // namespace

std::optional<std::array<std::string, 3>> different_units(const Volume& volume) {
  std::array<std::string, 3> units = axis_units(volume);
  if (units[0] == units[1] && units[1] == units[2]) return std::nullopt;
  return units;
}

std::array<double, 3> fair_shape(const std::array<double, 3>& sides, const std::array<std::string, 3>& units,
                                 const std::array<double, 3>& samples) {
  for (size_t i = 0; i < 3; ++i) {
    const size_t b = (i + 1) % 3, c = (i + 2) % 3;
    if (units[b] != units[c] || units[b].empty()) continue;
    std::array<double, 3> shape{1, 1, 1};
    if (samples[i] > 1) shape[i] = third_axis * std::sqrt(sides[b] * sides[c]) / sides[i];
    return shape;
  }
  return {samples[0] / sides[0], samples[1] / sides[1], samples[2] / sides[2]};
}

std::optional<std::array<double, 3>> picture_shape(const Volume& volume, const RenderArguments& a) {
  if (a.shape == "stored") return std::nullopt;
  const bccsplat_volume_info v = volume_info(volume);
  if (a.shape != "auto") {
    const std::vector<double> given = option_numbers("--shape", a.shape, 3);
    if (std::any_of(given.begin(), given.end(), [](double f) { return !(f > 0); }))
      fail_usage("--shape ", a.shape, ": auto, stored or three factors above 0 are expected");
    return std::array{given[0], given[1], given[2]};
  }
  const auto units = different_units(volume);
  if (!units || speaks_of_the_world(a) || !along_the_world(v)) return std::nullopt;
  const std::array<double, 3> sides = sides_of(v);
  const std::array<double, 3> shape = fair_shape(
      sides, *units,
      {static_cast<double>(v.dims[0]), static_cast<double>(v.dims[1]), static_cast<double>(v.dims[2])});
  const auto [least, most] = std::minmax_element(shape.begin(), shape.end());
  if (!(*least > 0) || *most <= as_it_is * *least) return std::nullopt;
  if (!a.common.quiet) tell(a, *units, sides, shape);
  return shape;
}

} // namespace bcc4
