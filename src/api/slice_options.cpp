// SPDX-License-Identifier: Apache-2.0
#include "api/slice_options.h"

#include <algorithm>
#include <cmath>

#include "api/structs.h"

namespace bccsplat::api {
namespace {

// x0 y0 z0 x1 y1 z1
IndexBox read_box(const double* numbers, const Lattice4& lattice) {
  IndexBox box;
  std::copy_n(numbers, 3, box.begin.begin()), std::copy_n(numbers + 3, 3, box.end.begin());
  for (size_t a = 0; a < 3; ++a)
    if (!(std::isfinite(box.begin[a]) && std::isfinite(box.end[a]) && box.begin[a] <= box.end[a]))
      fail(Code::invalid_argument, "slice: the box goes from ", box.begin[a], " to ", box.end[a],
           " along axis ", a);
  return clip_to_samples(box, lattice);
}

} // namespace

HypersliceOptions read_slice_options(const bccsplat_slice_options& o, const VolumeInfo& info) {
  HypersliceOptions r;
  if (o.lattice == BCCSPLAT_LATTICE_BCC)
    r.target = LatticeKind::bcc;
  else if (o.lattice == BCCSPLAT_LATTICE_CC)
    r.target = LatticeKind::cc;
  else if (o.lattice != BCCSPLAT_LATTICE_DEFAULT)
    fail(Code::invalid_argument, "slice: lattice ", o.lattice, " is no lattice of slices");
  if (!(o.interval[0] <= o.interval[1]))
    fail(Code::invalid_argument, "slice: interval[0] is larger than interval[1]");
  if (o.slab < 0 || o.slab > BCCSPLAT_SLAB_MAXIMUM) fail(Code::invalid_argument, "slice: slab ", o.slab);
  if (o.method < 0 || o.method > BCCSPLAT_METHOD_EXTRACTED)
    fail(Code::invalid_argument, "slice: method ", o.method);
  r.interval = {o.interval[0], o.interval[1]};
  r.thickness.length = o.thickness;
  if (o.slab == BCCSPLAT_SLAB_SUM) r.thickness.kind = ThicknessKind::sum;
  if (o.slab == BCCSPLAT_SLAB_MAXIMUM) r.thickness.kind = ThicknessKind::maximum;
  r.spacing = o.spacing;
  r.time_length = o.time_length != 0 ? o.time_length : std::cbrt(std::fabs(info.affine.determinant()));
  if (o.box) r.box = read_box(o.box, info.lattice);
  if (o.method == BCCSPLAT_METHOD_MERGED) r.method = SliceMethod::merged;
  if (o.method == BCCSPLAT_METHOD_RESAMPLED) r.method = SliceMethod::resampled;
  return r;
}

Hyperplane read_hyperplane(const bccsplat_hyperplane* hyperplane, const bccsplat_slice_options& o,
                           HypersliceOptions& options) {
  if (!o.point && !o.basis) {
    require(hyperplane, "hyperplane");
    const auto h = read_struct(hyperplane, "bccsplat_hyperplane");
    return {h.a, h.b, h.c, h.d, h.e};
  }
  require(o.point, "bccsplat_slice_options.point"), require(o.basis, "bccsplat_slice_options.basis");
  if (hyperplane)
    fail(Code::invalid_argument,
         "slice: the hyperplane is given twice, by its normal and by point and basis");
  Vec4 point;
  std::array<Vec4, 3> directions;
  std::copy_n(o.point, 4, point.begin());
  for (size_t k = 0; k < 3; ++k) std::copy_n(o.basis + 4 * k, 4, directions[k].begin());
  options.axes = plane_axes(point, directions);
  return hyperplane_of(*options.axes);
}

PlaneOptions extraction_options(const HypersliceOptions& o) {
  if (o.thickness.length != 0 || o.has_interval() || o.spacing != 0 || o.target || o.box)
    fail(Code::unsupported, "slice: extracted points take no thickness, interval, spacing, lattice or box");
  PlaneOptions plane;
  plane.time_length = o.time_length;
  plane.axes = o.axes;
  return plane;
}

} // namespace bccsplat::api
