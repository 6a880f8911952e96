// SPDX-License-Identifier: Apache-2.0
#include "api/slice_options.h"

#include <algorithm>
#include <cmath>

#include "api/numbers.h"
#include "api/structs.h"

namespace bccsplat::api {
namespace {

// x0 y0 z0 x1 y1 z1
IndexBox read_box(const double* numbers, const Lattice4& lattice) {
  IndexBox box;
  std::copy_n(numbers, 3, box.begin.begin()), std::copy_n(numbers + 3, 3, box.end.begin());
  for (size_t i = 0; i < 6; ++i) require_number(numbers[i], "bccsplat_slice_options.box");
  for (size_t a = 0; a < 3; ++a)
    if (!(box.begin[a] <= box.end[a]))
      fail(Code::invalid_argument, "slice: the box goes from ", box.begin[a], " to ", box.end[a],
           " along axis ", a);
  return clip_to_samples(box, lattice);
}

constexpr double widest_band = 64; // a mistake beyond it

// Coarser lattices than this would have no site in the volume but at its corners.
double longest_axis(const Lattice4& lattice) {
  return *std::max_element(lattice.dims.begin(), lattice.dims.end());
}

} // namespace

HypersliceOptions read_slice_options(const bccsplat_slice_options& o, const OpenVolume& volume) {
  const VolumeInfo& info = volume.info();
  HypersliceOptions r;
  if (o.lattice == BCCSPLAT_LATTICE_BCC)
    r.target = LatticeKind::bcc;
  else if (o.lattice == BCCSPLAT_LATTICE_CC)
    r.target = LatticeKind::cc;
  else if (o.lattice != BCCSPLAT_LATTICE_DEFAULT)
    fail(Code::invalid_argument, "slice: lattice ", o.lattice, " is no lattice of slices");
  require_numbers(o.interval, "bccsplat_slice_options.interval");
  require_range(o.thickness, 0, largest_number, "bccsplat_slice_options.thickness");
  require_zero_or(o.spacing, smallest_length, longest_axis(info.lattice), "bccsplat_slice_options.spacing");
  require_zero_or(o.time_length, smallest_length, largest_number, "bccsplat_slice_options.time_length");
  if (!(o.interval[0] <= o.interval[1]))
    fail(Code::invalid_argument, "slice: interval[0] is larger than interval[1]");
  require_choice(o.slab, BCCSPLAT_SLAB_MAXIMUM, "bccsplat_slice_options.slab");
  require_choice(o.method, BCCSPLAT_METHOD_EXTRACTED, "bccsplat_slice_options.method");
  r.interval = {o.interval[0], o.interval[1]};
  r.thickness.length = o.thickness;
  if (o.slab == BCCSPLAT_SLAB_SUM) r.thickness.kind = ThicknessKind::sum;
  if (o.slab == BCCSPLAT_SLAB_MAXIMUM) r.thickness.kind = ThicknessKind::maximum;
  r.spacing = o.spacing;
  if (std::any_of(o.bandwidth, o.bandwidth + 4, [](double w) { return w != 0; })) {
    r.bandwidth.emplace();
    for (size_t i = 0; i < 4; ++i) {
      require_range(o.bandwidth[i], 1, widest_band, "bccsplat_slice_options.bandwidth");
      (*r.bandwidth)[i] = o.bandwidth[i];
    }
  }
  r.time_length = o.time_length != 0 ? o.time_length : std::cbrt(std::fabs(volume.affine().determinant()));
  if (o.box) r.box = read_box(o.box, info.lattice);
  require_choice(o.space, BCCSPLAT_SPACE_EVEN, "bccsplat_slice_options.space");
  r.once = o.once != 0;
  require_choice(o.motion, BCCSPLAT_MOTION_ON, "bccsplat_slice_options.motion");
  require_zero(o.reserved, "bccsplat_slice_options.reserved");
  r.motion = o.motion == BCCSPLAT_MOTION_ON;
  if (o.space == BCCSPLAT_SPACE_EVEN && volume.axes()->any()) r.even = volume.axes();
  if (o.method == BCCSPLAT_METHOD_MERGED) r.method = SliceMethod::merged;
  if (o.method == BCCSPLAT_METHOD_RESAMPLED) r.method = SliceMethod::resampled;
  if (o.method == BCCSPLAT_METHOD_EXTRACTED) r.method = SliceMethod::extracted;
  return r;
}

Hyperplane read_hyperplane(const bccsplat_hyperplane* hyperplane, const bccsplat_slice_options& o,
                           HypersliceOptions& options) {
  if (!o.point && !o.basis) {
    require(hyperplane, "hyperplane");
    const auto h = read_struct(hyperplane, "bccsplat_hyperplane");
    require_zero(h.reserved, "bccsplat_hyperplane.reserved");
    // The normal may have any length.
    require_number(h.a, "bccsplat_hyperplane.a", DBL_MAX),
        require_number(h.b, "bccsplat_hyperplane.b", DBL_MAX);
    require_number(h.c, "bccsplat_hyperplane.c", DBL_MAX),
        require_number(h.d, "bccsplat_hyperplane.d", DBL_MAX);
    require_number(h.e, "bccsplat_hyperplane.e", DBL_MAX);
    const Hyperplane made(h.a, h.b, h.c, h.d, h.e);
    require_number(made[4], "bccsplat_hyperplane: its distance from the origin");
    return made;
  }
  require(o.point, "bccsplat_slice_options.point"), require(o.basis, "bccsplat_slice_options.basis");
  if (hyperplane)
    fail(Code::invalid_argument,
         "slice: the hyperplane is given twice, by its normal and by point and basis");
  for (size_t i = 0; i < 4; ++i) require_number(o.point[i], "bccsplat_slice_options.point");
  for (size_t i = 0; i < 12; ++i) require_number(o.basis[i], "bccsplat_slice_options.basis");
  Vec4 point;
  std::array<Vec4, 3> directions;
  std::copy_n(o.point, 4, point.begin());
  for (size_t k = 0; k < 3; ++k) std::copy_n(o.basis + 4 * k, 4, directions[k].begin());
  options.axes = plane_axes(point, directions);
  return hyperplane_of(*options.axes);
}

} // namespace bccsplat::api
