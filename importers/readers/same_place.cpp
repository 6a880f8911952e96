// SPDX-License-Identifier: Apache-2.0
#include "readers/same_place.h"

#include <algorithm>
#include <cmath>

#include "readers/error.h"

namespace bcc4 {
namespace {

// The distance of the vectors in column `c`; of the translation for 3.
double apart(const Affine& a, const Affine& b, size_t c) {
  return std::hypot(a[c] - b[c], a[4 + c] - b[4 + c], a[8 + c] - b[8 + c]);
}

} // namespace

double shift_of(const Affine& a, const Affine& b, const std::array<uint64_t, 3>& samples, bool with_origin) {
  double shift = with_origin ? apart(a, b, 3) : 0, voxel = HUGE_VAL;
  for (size_t axis = 0; axis < 3; ++axis) {
    shift += apart(a, b, axis) * static_cast<double>(samples[axis] - 1);
    voxel = std::min(voxel, std::hypot(a[axis], a[4 + axis], a[8 + axis]));
  }
  return shift / voxel;
}

void require_volume(const Affine& affine, const ReaderOptions& options, const std::string& path,
                    const std::string& what) {
  if (options.spacing) return;
  for (const double v : affine)
    if (!std::isfinite(v)) fail_input(path, ": ", what, " is not finite: give --spacing");
  if (!(std::abs(determinant(affine)) > 0)) fail_input(path, ": ", what, " spans no volume: give --spacing");
}

void require_same_place(const SeriesDescription& first, const SeriesDescription& next,
                        const std::array<uint64_t, 3>& samples, const ReaderOptions& options,
                        const std::string& path) {
  for (size_t axis = 0; axis < first.places.size(); ++axis)
    if (first.places[axis].coordinates != next.places[axis].coordinates)
      fail_input(path, ": its coordinates along ", "xyz"[axis], " are not those of ",
                 first.files.front().path, ": import them one by one");
  if (options.spacing) return;
  const double shift = shift_of(first.affine, next.affine, samples, !options.origin);
  if (!(shift <= same_place))
    fail_input(path, ": its spacing, directions or origin differ from those of ", first.files.front().path,
               ": samples lie up to ", short_number(shift, 3),
               " voxels elsewhere; resample the files to one grid, or give --spacing and --origin for all");
  if (first.spatial_unit != next.spatial_unit)
    fail_input(path, ": its space is in \"", next.spatial_unit, "\", that of ", first.files.front().path,
               " in \"", first.spatial_unit, "\": give --spacing for all");
}

} // namespace bcc4
