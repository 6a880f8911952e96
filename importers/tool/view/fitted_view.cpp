// SPDX-License-Identifier: Apache-2.0
// Fits cameras to what is seen of a file, found once for all its moments.
#include "tool/view/fitted_view.h"

#include <algorithm>
#include <cmath>

#include "tool/exit.h"
#include "tool/view/render_function.h"
#include "tool/view/time_slice.h"

namespace bcc4 {
namespace {

constexpr size_t most_moments = 4; // of a series, that are looked at

// The box of the world around all of a slice.
std::array<double, 6> box_of(const bccsplat_slice_info& s) {
  std::array<double, 6> box{HUGE_VAL, HUGE_VAL, HUGE_VAL, -HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
  for (size_t corner = 0; corner < 8; ++corner)
    for (size_t r = 0; r < 3; ++r) {
      double at = s.affine[4 * r + 3];
      for (size_t c = 0; c < 3; ++c) at += s.affine[4 * r + c] * s.extent[c][corner >> c & 1];
      box[r] = std::min(box[r], at), box[r + 3] = std::max(box[r + 3], at);
    }
  return box;
}

} // namespace

FittedView::Bounds united(const FittedView::Bounds& a, const FittedView::Bounds& b) {
  FittedView::Bounds out{};
  for (size_t i = 0; i < 3; ++i) out[i] = std::min(a[i], b[i]), out[i + 3] = std::max(a[i + 3], b[i + 3]);
  return out;
}

FittedView::FittedView(const Volume& volume, uint32_t channel, const RenderArguments& arguments,
                       TransferFunction function, int32_t projection, const std::array<uint32_t, 2>& size,
                       const std::vector<Picture>& pictures)
    : volume_(volume), channel_(channel), arguments_(arguments), function_(std::move(function)), size_(size),
      several_planes_(pictures.size() > 1 && !pictures.front().where.is_time_slice) {
  fit_.projection = projection;
  const auto [about_x, about_y] = rotations(arguments);
  fit_.rotate_x_degrees = about_x, fit_.rotate_y_degrees = about_y;
  fit_.side = BCCSPLAT_SIDE_FRONT;
  if (!pictures.empty() && pictures.front().where.is_time_slice)
    check(bccsplat_volume_get_side(volume.get(), &fit_.side), "camera");
}

FittedView::Bounds FittedView::seen(const Slice& slice) const {
  const bool whole = arguments_.fit_domain.value_or(false) || several_planes_ ||
                     (arguments_.annotate && arguments_.annotate->box);
  if (whole) return box_of(slice_info(slice));
  Bounds bounds{};
  const bccsplat_transfer_function f = as_struct(function_);
  check(bccsplat_slice_get_seen_bounds(slice.get(), &f, bounds.data()), "camera");
  return bounds;
}

std::optional<FittedView::Bounds> FittedView::seen_of_series(const Cut& shape) const {
  const bccsplat_volume_info v = volume_info(volume_);
  const uint64_t first = v.part_first, end = v.part_end > 0 ? v.part_end : v.dims[3];
  const uint64_t moments = std::min<uint64_t>(end - first, most_moments);
  std::optional<Bounds> bounds;
  for (uint64_t n = 0; n < moments; ++n) {
    const uint64_t frame = moments == 1 ? first : first + n * (end - 1 - first) / (moments - 1);
    Cut cut = cut_at_index(volume_, static_cast<double>(frame));
    set_shape(cut, arguments_.which);
    cut.even = shape.even;
    const bool merged = shape.method != BCCSPLAT_METHOD_EXTRACTED;
    cut.level = merged && !arguments_.which.level ? v.level_count : shape.level;
    try {
      const Bounds now = seen(cut_slice(volume_, cut, channel_));
      bounds = bounds ? united(*bounds, now) : now;
    } catch (const Error& e) { // a damaged moment is no reason not to draw another one
      if (exit_of(e.code()) != Exit::bad_input) throw;
    }
  }
  return bounds;
}

void FittedView::find_seen(const Picture& picture) {
  const bool moment = picture.where.is_time_slice && volume_info(volume_).dims[3] > 1;
  if (!bounds_ && moment) bounds_ = seen_of_series(picture.where);
}

std::array<double, 3> FittedView::middle(const Picture& picture, const std::function<Slice()>& cut) {
  find_seen(picture);
  if (!bounds_) bounds_ = seen(cut());
  const Bounds& b = *bounds_;
  return {(b[0] + b[3]) / 2, (b[1] + b[4]) / 2, (b[2] + b[5]) / 2};
}

bccsplat_camera FittedView::camera(const Slice& slice, const Picture& picture) {
  find_seen(picture);
  if (!bounds_) bounds_ = seen(slice);
  bccsplat_fit fit = fit_;
  fit.rotate_y_degrees += picture.turn;
  const Bounds all = beside_ ? united(*bounds_, *beside_) : *bounds_;
  std::copy(all.begin(), all.end(), fit.bounds);
  auto camera = sized<bccsplat_camera>();
  check(bccsplat_fit_camera(&fit, size_[0], size_[1], &camera), "camera");
  return camera;
}

TransferFunction seen_function(const RenderArguments& a, const std::optional<TransferFunction>& chosen,
                               const bccsplat_look& look, double air) {
  TransferFunction f;
  f.colors = {{0, 1, 1, 1}};
  if (a.mode == BCCSPLAT_MODE_ISOSURFACE) {
    double low = look.iso_value, high = look.iso_value;
    for (size_t i = 0; i < a.iso.size(); ++i) {
      low = i == 0 ? a.iso[i].value : std::min(low, a.iso[i].value);
      high = i == 0 ? a.iso[i].value : std::max(high, a.iso[i].value);
    }
    f.opacities = air < low ? std::vector<std::array<double, 2>>{{low, 0}, {low, 1}}
                            : std::vector<std::array<double, 2>>{{high, 1}, {high, 0}};
    return f;
  }
  if (chosen) return *chosen;
  for (uint32_t i = 0; i < look.opacity_count; ++i)
    f.opacities.push_back({look.opacities[i][0], look.opacities[i][1]});
  return f;
}

} // namespace bcc4
