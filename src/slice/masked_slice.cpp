// SPDX-License-Identifier: Apache-2.0
#include "slice/masked_slice.h"

#include <algorithm>

#include "base/would_block.h"
#include "field/masks.h"

namespace bccsplat {
namespace {

void set_mask(Slice& slice, const Masks& masks, int64_t first, int64_t last) {
  std::vector<FrameMaskPtr> frames;
  Attempts attempts;
  for (int64_t f = first; f <= last; ++f) attempts.attempt([&] { frames.push_back(masks.frame(f)); });
  attempts.throw_if_waiting();
  auto mask = std::make_shared<const SliceMask>(masks, slice.origin, slice.basis, first, std::move(frames));
  if (!mask->any()) return;
  slice.mask = std::move(mask);
  slice.holes_by_mask = !slice.has_holes;
  slice.has_holes = true;
}

} // namespace

void mask_time_slice(Slice& slice, const Coefficients& coefficients) {
  const Masks* masks = coefficients.masks();
  if (!masks) return;
  const int64_t frame = masks->counted_frame(slice.frame);
  set_mask(slice, *masks, frame, frame);
}

std::array<double, 2> moments_of(const Slice& slice) {
  double low = 0, high = 0;
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 p;
    for (size_t a = 0; a < 3; ++a) p[a] = corner >> a & 1 ? slice.domain_end[a] : slice.domain_begin[a];
    const Vec3 uvw = slice.lattice_to_slice.point(p);
    double t = slice.origin[3];
    for (size_t k = 0; k < 3; ++k) t += slice.basis[k][3] * uvw[k];
    low = corner == 0 ? t : std::min(low, t), high = corner == 0 ? t : std::max(high, t);
  }
  return {low, high};
}

void mask_slice(Slice& slice, const Coefficients& coefficients) {
  const Masks* masks = coefficients.masks();
  if (!masks || slice.empty()) return;
  const auto [low, high] = moments_of(slice);
  set_mask(slice, *masks, masks->counted_frame(low), masks->counted_frame(high));
}

} // namespace bccsplat
