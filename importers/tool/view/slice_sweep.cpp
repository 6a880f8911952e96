// SPDX-License-Identifier: Apache-2.0
#include "tool/view/slice_sweep.h"

#include <algorithm>
#include <cmath>

#include "readers/sequence.h"
#include "tool/cli.h"
#include "tool/view/time_slice.h"

namespace bcc4 {
namespace {

// The normal of directions u, v, w: component i is a minor of their matrix, with alternating sign.
std::array<double, 4> unit_normal(const std::array<double, 12>& basis) {
  std::array<double, 4> n{};
  for (size_t i = 0; i < 4; ++i) {
    std::array<size_t, 3> c{};
    for (size_t a = 0, k = 0; a < 4; ++a)
      if (a != i) c[k++] = a;
    const auto at = [&](size_t row, size_t column) { return basis[4 * row + c[column]]; };
    const double minor = at(0, 0) * (at(1, 1) * at(2, 2) - at(1, 2) * at(2, 1)) -
                         at(0, 1) * (at(1, 0) * at(2, 2) - at(1, 2) * at(2, 0)) +
                         at(0, 2) * (at(1, 0) * at(2, 1) - at(1, 1) * at(2, 0));
    n[i] = i % 2 == 0 ? -minor : minor; // along +t for directions x, y, z
  }
  const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] + n[3] * n[3]);
  if (length > 0)
    for (double& x : n) x /= length;
  return n;
}

Cut moved(const Volume& volume, const Cut& base, double offset) {
  Cut cut = base;
  if (cut.is_time_slice) {
    const double last = last_index(volume_info(volume)), to = base.index + offset;
    if (!(to >= 0 && to <= last)) fail_usage("--sweep: frame ", to, " is outside the series, 0 to ", last);
    const Cut there = cut_at_index(volume, to);
    std::copy(there.plane, there.plane + 5, cut.plane);
    cut.index = there.index, cut.time = there.time;
  } else if (cut.point) {
    const std::array<double, 4> normal = unit_normal(cut.basis);
    for (size_t i = 0; i < 4; ++i) (*cut.point)[i] += offset * normal[i];
  } else {
    const double* p = cut.plane;
    cut.plane[4] -= offset * std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + p[3] * p[3]);
  }
  return cut;
}

} // namespace

void add_sweep(const Command& command, SliceChoiceArguments& a) {
  command.add_text("--sweep", "A:B,N",
                   "N slices, moved along the unit normal from A to B samples (or frames)",
                   [&a](const std::string& text) {
                     std::string list = text;
                     std::replace(list.begin(), list.end(), ':', ',');
                     a.sweep = option_numbers("--sweep", list, 3);
                   });
}

std::vector<Cut> sweep(const Volume& volume, const SliceChoiceArguments& a) {
  const Cut base = resolve_cut(volume, a);
  if (!a.sweep) return {base};
  const double from = (*a.sweep)[0], to = (*a.sweep)[1], count = (*a.sweep)[2];
  if (!(count >= 2 && count <= 1e6) || count != std::floor(count))
    fail_usage("--sweep: N must be a whole number, 2 to 1000000");
  std::vector<Cut> cuts;
  for (double i = 0; i < count; ++i)
    cuts.push_back(moved(volume, base, from + (to - from) * i / (count - 1)));
  return cuts;
}

std::vector<std::string> sweep_names(const std::string& output, size_t count) {
  if (count == 1) return {output};
  if (!has_frame_pattern(output))
    fail_usage("-o ", output, ": ", count, " slices need a pattern such as slice.%03d.nrrd");
  std::vector<std::string> names;
  for (size_t i = 0; i < count; ++i) names.push_back(apply_frame_pattern(output, i));
  return names;
}

} // namespace bcc4
