// SPDX-License-Identifier: Apache-2.0
#include "readers/nifti/nifti_place.h"

#include <cmath>
#include <optional>

#include "readers/same_place.h"

namespace bcc4 {
namespace {

// Returns a size that is told, or 0.
double told_size(const NiftiHeader& h, size_t axis) {
  const double size = std::abs(h.real(h.fields().pixdim, axis + 1));
  return std::isfinite(size) ? size : 0;
}

std::array<double, 3> voxel_size(const NiftiHeader& h) {
  std::array<double, 3> size{};
  for (size_t a = 0; a < 3; ++a) size[a] = told_size(h, a) > 0 ? told_size(h, a) : 1;
  return size;
}

void warn_of_no_size(SeriesDescription& d, const NiftiHeader& h) {
  for (size_t a = 0; a < 3; ++a)
    if (static_cast<int64_t>(a) < h.dim(0) && h.dim(a + 1) > 1 && !(told_size(h, a) > 0))
      d.warnings.push_back(concat("pixdim[", a + 1, "] is ", h.real(h.fields().pixdim, a + 1),
                                  ": samples along ", "xyz"[a],
                                  " are taken to be 1 apart; --spacing sets it"));
}

std::optional<Affine> sform_of(const NiftiHeader& h) {
  if (h.code(h.fields().sform) <= 0) return std::nullopt;
  Affine m{};
  for (size_t i = 0; i < 12; ++i) m[i] = h.real(h.fields().srow, i);
  m[15] = 1;
  return m;
}

// A rotation by a quaternion whose first part is what the other three leave, and the sizes of voxels.
std::optional<Affine> qform_of(const NiftiHeader& h) {
  const NiftiFields& f = h.fields();
  if (h.code(f.qform) <= 0) return std::nullopt;
  const double b = h.real(f.quatern, 0), c = h.real(f.quatern, 1), e = h.real(f.quatern, 2);
  const double a = std::sqrt(std::max(0.0, 1 - (b * b + c * c + e * e)));
  std::array<double, 3> s = voxel_size(h);
  if (h.real(f.pixdim, 0) < 0) s[2] = -s[2];
  return affine_from_columns(
      {{{(a * a + b * b - c * c - e * e) * s[0], 2 * (b * c + a * e) * s[0], 2 * (b * e - a * c) * s[0]},
        {2 * (b * c - a * e) * s[1], (a * a + c * c - b * b - e * e) * s[1], 2 * (c * e + a * b) * s[1]},
        {2 * (b * e + a * c) * s[2], 2 * (c * e - a * b) * s[2], (a * a + e * e - c * c - b * b) * s[2]}}},
      {h.real(f.qoffset, 0), h.real(f.qoffset, 1), h.real(f.qoffset, 2)});
}

void compare_forms(SeriesDescription& d, const Affine& sform, const Affine& qform) {
  if (!spans_volume(sform))
    d.notes.push_back(concat("its sform spans no volume: the ", d.affine_origin, ", is taken"));
  else if (spans_volume(qform) && (determinant(sform) > 0) != (determinant(qform) > 0))
    d.notes.push_back(concat("its qform has the other handedness than its ", d.affine_origin,
                             ", which is taken: one of the two has left and right swapped"));
}

} // namespace

void set_affine(SeriesDescription& d, const NiftiHeader& h, const std::string& path,
                const ReaderOptions& options) {
  const std::optional<Affine> sform = sform_of(h), qform = qform_of(h);
  const bool qform_stands_in = sform && qform && !spans_volume(*sform) && spans_volume(*qform);
  if (sform && !qform_stands_in) {
    d.affine = *sform;
    d.affine_origin = concat("sform, code ", h.code(h.fields().sform));
  } else if (qform) {
    d.affine = *qform;
    d.affine_origin = concat("qform, code ", h.code(h.fields().qform));
  } else {
    const auto size = voxel_size(h);
    d.affine = affine_from_columns({{{size[0], 0, 0}, {0, size[1], 0}, {0, 0, size[2]}}}, {0, 0, 0});
    d.affine_origin = "pixdim only";
  }
  if (!options.spacing && (!sform || qform_stands_in)) warn_of_no_size(d, h);
  require_volume(d.affine, options, path, concat("its affine (", d.affine_origin, ")"));
  if (sform && qform) compare_forms(d, *sform, *qform);
  static constexpr const char* units[] = {"", "m", "mm", "um"};
  d.spatial_unit = (h.units() & 7) < 4 ? units[h.units() & 7] : "";
  d.attributes.emplace_back("space", "right-anterior-superior");
}

} // namespace bcc4
