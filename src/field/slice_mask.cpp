// SPDX-License-Identifier: Apache-2.0
// Looks samples up by the rule of masks.h, point by point, in rectangles of a plane, or as a grid.
#include "field/slice_mask.h"

#include <algorithm>

namespace bccsplat {
SliceMask::SliceMask(const std::array<int64_t, 4>& samples, const TurningAxes& turning, const Vec4& origin,
                     const std::array<Vec4, 3>& basis, int64_t first, std::vector<FrameMaskPtr> frames)
    : n_(samples), turning_(turning), origin_(origin), basis_(basis), first_(first),
      frames_(std::move(frames)) {}

SliceMask::SliceMask(const Masks& masks, const Vec4& origin, const std::array<Vec4, 3>& basis, int64_t first,
                     std::vector<FrameMaskPtr> frames)
    : SliceMask(masks.samples(), masks.turning(), origin, basis, first, std::move(frames)) {}

bool SliceMask::missing(const Vec3& uvw) const {
  Vec4 p;
  for (size_t a = 0; a < 4; ++a)
    p[a] = origin_[a] + basis_[0][a] * uvw[0] + basis_[1][a] * uvw[1] + basis_[2][a] * uvw[2];
  const auto nearest = [&](size_t a) { return sample_at(a, p[a]); };
  const FrameMaskPtr& frame = frames_[frame_at(p[3])];
  return frame && frame->at({nearest(0), nearest(1), nearest(2)}) &&
         std::all_of(others_.begin(), others_.end(), [&](const auto& m) { return m->missing(uvw); });
}

std::optional<size_t> SliceMask::axis_along(size_t axis) const {
  std::optional<size_t> along;
  for (size_t a = 0; a < 4; ++a) {
    if (basis_[axis][a] == 0) continue;
    if (along) return std::nullopt;
    along = a;
  }
  return along;
}

std::optional<SliceMask::Grid> SliceMask::grid() const {
  Grid grid;
  std::array<bool, 4> taken{};
  for (size_t k = 0; k < 3; ++k) {
    const auto along = axis_along(k);
    if (!along || taken[*along] || (even_ && *along < 3 && even_->uneven(*along))) return std::nullopt;
    const bool time = *along == 3;
    taken[*along] = true;
    grid.samples[k] = static_cast<int32_t>(time ? static_cast<int64_t>(frames_.size()) : n_[*along]);
    grid.turning[k] = !time && turning_[*along];
    grid.scale[k] = basis_[k][*along];
    grid.offset[k] = origin_[*along] - (time ? static_cast<double>(first_) : 0);
  }
  const bool alike = std::all_of(others_.begin(), others_.end(),
                                 [&](const auto& other) { return other->grid() == std::optional(grid); });
  return alike ? std::optional(grid) : std::nullopt;
}

SliceMask SliceMask::from_even(const std::shared_ptr<const UnevenAxes>& axes, const Vec4& origin) const {
  SliceMask mask = *this;
  mask.even_ = axes, mask.origin_ = origin;
  for (auto& other : mask.others_) other = std::make_shared<const SliceMask>(other->from_even(axes, origin));
  return mask;
}

SliceMask SliceMask::also(std::vector<std::shared_ptr<const SliceMask>> others) const {
  SliceMask mask = *this;
  mask.others_ = std::move(others);
  return mask;
}

bool SliceMask::any() const {
  return std::any_of(frames_.begin(), frames_.end(),
                     [](const FrameMaskPtr& f) { return f && f->count() > 0; });
}

MaskPlane::MaskPlane(const SliceMask& mask, const Vec3& o, const Vec3& u, const Vec3& v) {
  add(mask, o, u, v);
}

void MaskPlane::add(const SliceMask& mask, const Vec3& o, const Vec3& u, const Vec3& v) {
  const auto direction = [&](const Vec3& d, size_t a) {
    return mask.basis_[0][a] * d[0] + mask.basis_[1][a] * d[1] + mask.basis_[2][a] * d[2];
  };
  Layer layer{&mask, {}, {}, {}};
  for (size_t a = 0; a < 4; ++a) {
    layer.at[a] = mask.origin_[a] + direction(o, a);
    layer.along_i[a] = direction(u, a), layer.along_j[a] = direction(v, a);
  }
  layers_.push_back(layer);
  for (const auto& other : mask.others_) add(*other, o, u, v);
}

std::array<double, 2> MaskPlane::Layer::between(size_t axis, const std::array<double, 2>& i,
                                                const std::array<double, 2>& j) const {
  constexpr double room = 1e-6; // for the rounding of either way to compute a position
  const std::array<double, 4> ends{i[0] * along_i[axis], i[1] * along_i[axis], j[0] * along_j[axis],
                                   j[1] * along_j[axis]};
  return {at[axis] + std::min(ends[0], ends[1]) + std::min(ends[2], ends[3]) - room,
          at[axis] + std::max(ends[0], ends[1]) + std::max(ends[2], ends[3]) + room};
}

bool MaskPlane::Layer::missing(double i, double j) const {
  const FrameMaskPtr& frame =
      mask->frames_[mask->frames_.size() == 1 ? 0 : mask->frame_at(position(3, i, j))];
  if (!frame) return false;
  const auto nearest = [&](size_t a) { return mask->sample_at(a, position(a, i, j)); };
  return frame->at({nearest(0), nearest(1), nearest(2)});
}

Missing MaskPlane::Layer::within(const std::array<double, 2>& i, const std::array<double, 2>& j) const {
  std::array<int64_t, 3> first, last;
  for (size_t a = 0; a < 3; ++a) {
    const auto [low, high] = between(a, i, j);
    first[a] = mask->sample_at(a, low), last[a] = mask->sample_at(a, high);
    // Across the end of a periodic axis all of it is looked at, which may say some for none or all.
    if (mask->turning_[a] && (low < 0 || high > static_cast<double>(mask->n_[a]) - 1))
      first[a] = 0, last[a] = mask->n_[a] - 1;
  }
  const auto [low, high] = between(3, i, j);
  bool none = true, all = true;
  for (size_t f = mask->frame_at(low); f <= mask->frame_at(high); ++f) {
    const FrameMaskPtr& frame = mask->frames_[f];
    const Missing m = frame ? frame->within(first, last) : Missing::none;
    none = none && m == Missing::none, all = all && m == Missing::all;
  }
  return none ? Missing::none : all ? Missing::all : Missing::some;
}

bool MaskPlane::missing(double i, double j) const {
  return std::all_of(layers_.begin(), layers_.end(), [&](const Layer& l) { return l.missing(i, j); });
}

Missing MaskPlane::within(const std::array<double, 2>& i, const std::array<double, 2>& j) const {
  bool all = true;
  for (const Layer& l : layers_) {
    const Missing m = l.within(i, j);
    if (m == Missing::none) return Missing::none;
    all = all && m == Missing::all;
  }
  return all ? Missing::all : Missing::some;
}

} // namespace bccsplat
