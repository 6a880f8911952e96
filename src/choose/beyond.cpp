// SPDX-License-Identifier: Apache-2.0
#include "choose/beyond.h"

#include <algorithm>
#include <cmath>

namespace bccsplat::series {
namespace {

// What a writer does by default (BCCSPLAT_ENDS_DEFAULT): from so many layers on it predicts those beyond
// them.
constexpr uint64_t kPredictedLayers = 20;
// The same of faces: planes outside are a part of them that is no larger, or than that where it is asked to.
constexpr double kDefaultPart = 1.0 / 16, kAskedPart = 1.0 / 5;
constexpr double kOfSites = 2;       // powers of them by which errors fall
constexpr double kPlanesOutside = 4; // both faces of an axis together, or both ends of time

// Over the planes or layers inside.
double outside_part(const LatticeShape& s, const std::array<uint64_t, 4>& dims, size_t axis) {
  return kPlanesOutside / (last_plane(s, axis, dims[axis]) + 1);
}

} // namespace

int32_t faces_of_part(const LatticeShape& s, const std::array<uint64_t, 4>& dims) {
  if (s.faces >= BCCSPLAT_FACES_PREDICT_X) return s.faces;
  const bool asked = s.faces == BCCSPLAT_FACES_PREDICT;
  if (s.faces == BCCSPLAT_FACES_MIRROR || (has_source_planes(s) && !asked)) return BCCSPLAT_FACES_MIRROR;
  int32_t along = 0;
  for (size_t a = 0; a < 3; ++a)
    if (!is_periodic(s.periodic, a) &&
        kPlanesOutside <= (asked ? kAskedPart : kDefaultPart) * (last_plane(s, a, dims[a]) + kPlanesOutside))
      along += face_bit(a);
  return along > 0 ? along : BCCSPLAT_FACES_MIRROR;
}

bool predicts_ends(const LatticeShape& s, const std::array<uint64_t, 4>& dims) {
  if (s.ends != BCCSPLAT_ENDS_DEFAULT || dims[3] == 1) return s.ends == BCCSPLAT_ENDS_PREDICT && dims[3] > 1;
  return is_bcc(s) && inner_layers(s, dims) >= kPredictedLayers;
}

LatticeShape with_beyond(LatticeShape s, Beyond beyond) {
  if (beyond == Beyond::plain) return s;
  if (s.faces == BCCSPLAT_FACES_DEFAULT && !has_source_planes(s)) s.faces = BCCSPLAT_FACES_PREDICT;
  if (beyond == Beyond::all && s.ends == BCCSPLAT_ENDS_DEFAULT && !has_source_frames(s))
    s.ends = BCCSPLAT_ENDS_PREDICT;
  return s;
}

bool goes_on_alike(const LatticeShape& a, const LatticeShape& b, const std::array<uint64_t, 4>& dims) {
  return faces_of_part(a, dims) == faces_of_part(b, dims) && predicts_ends(a, dims) == predicts_ends(b, dims);
}

double outside_share(const LatticeShape& s, const std::array<uint64_t, 4>& dims, int32_t across, bool ends) {
  double all = ends ? 1 + outside_part(s, dims, 3) : 1;
  for (size_t a = 0; a < 3; ++a)
    if (across & face_bit(a)) all *= 1 + outside_part(s, dims, a);
  return all - 1;
}

double outside_share(const LatticeShape& s, const std::array<uint64_t, 4>& dims) {
  return outside_share(s, dims, faces_of_part(s, dims), predicts_ends(s, dims));
}

double whole_density(const LatticeShape& s, const std::array<uint64_t, 4>& dims) {
  return site_density(s, dims) * (1 + outside_share(s, dims));
}

double merit(double psnr, const LatticeShape& s, const std::array<uint64_t, 4>& dims, double density) {
  return psnr - kOfSites * 10 * std::log10(std::max(1e-9, whole_density(s, dims) / density));
}

} // namespace bccsplat::series
