// SPDX-License-Identifier: Apache-2.0
// The part of SheetSource for sheets that have fewer samples than the picture, along the normal or side by
// side; see raise.h.
#include <algorithm>
#include <utility>

#include "splat/tile/sheet_source.h"

namespace bccsplat {

// Makes sheet k out of those of the ring on either side.
void SheetSource::blend_sheet(int64_t k) {
  const RaiseAxis& z = plan_.raise.z;
  const size_t entry = k - z.first;
  BlendArgs b;
  PixelRect touched;
  for (size_t t = 0; t < static_cast<size_t>(plan_.raise.depth_taps); ++t) {
    const int64_t from = z.sample[entry] + static_cast<int64_t>(t);
    if (!stack_filled_[from]) continue;
    b.plane[b.taps] = m_.stack[from].data();
    b.weight[b.taps++] = z.weight[t * z.pitch + entry];
    touched.include(stack_touched_[from]);
  }
  filled_[k] = b.taps > 0;
  if (b.taps == 0) return;
  const bool at_pixels = plan_.raise.taps == 0;
  const PixelRect now = whole_vectors(touched);
  b.pitch = m_.sample_pitch;
  b.out = at_pixels ? m_.plane_origin(k, 0) : m_.samples.data();
  b.out_pitch = at_pixels ? m_.plane_pitch : m_.sample_pitch;
  b.x0 = now.x0, b.x1 = now.x1, b.y0 = now.y0, b.y1 = now.y1;
  clear_around(std::exchange(at_pixels ? plane_touched_[k] : samples_held_, now), now, b.out, b.out_pitch);
  loops_.blend(b);
  if (!at_pixels) raise_sheet(k, touched);
}

// Works out what the tile sees of each gap.
void SheetSource::prepare_fan() {
  const RaiseFan& fan = plan_.raise.fan;
  const size_t gaps = plan_.gaps.last - plan_.gaps.first + 1;
  gap_rect_.resize(gaps), inverse_near_.resize(gaps), inverse_far_.resize(gaps);
  for (size_t n = 0; n < gaps; ++n) {
    const int64_t s = plan_.gaps.first + static_cast<int64_t>(n);
    const Scales scales = gap_scales(plan_, s, s);
    const auto [x0, x1] = fan_samples(fan, fan.x, scales, {tile_.x, tile_.x + tile_.width});
    const auto [y0, y1] = fan_samples(fan, fan.y, scales, {tile_.y, tile_.y + tile_.height});
    gap_rect_[n] = {x0 - tile_.ring_x, y0 - tile_.ring_y, x1 - tile_.ring_x, y1 - tile_.ring_y};
    inverse_near_[n] = static_cast<float>(1 / scales[0]), inverse_far_[n] = static_cast<float>(1 / scales[1]);
  }
  fan_.rect = gap_rect_.front().data();
  fan_.inverse_near = inverse_near_.data(), fan_.inverse_far = inverse_far_.data();
  fan_.per_x = static_cast<float>(1 / fan.x.per), fan_.per_y = static_cast<float>(1 / fan.y.per);
  fan_.foot_x = static_cast<float>(fan.x.foot - tile_.x),
  fan_.foot_y = static_cast<float>(fan.y.foot - tile_.y);
  fan_.sample_foot_x = -tile_.ring_x, fan_.sample_foot_y = -tile_.ring_y;
  fan_.around = fan.taps / 2 + 1, fan_.border = fan.border + 1;
  fan_.width = tile_.width, fan_.height = tile_.height;
}

// Returns the pixels of the plane that any of the samples `touched` reaches.
PixelRect SheetSource::raised_pixels(const PixelRect& touched) const {
  if (touched.empty()) return {};
  const bool fan = plan_.raise.fan.taps > 0;
  const auto range = [&](const RaiseAxis& axis, int first_pixel, int count, int low, int high) {
    const int32_t* const at = &axis.sample[first_pixel - axis.first];
    // A pixel's samples are at[n] .. at[n] + taps - 1, rising.
    const auto* const from = std::lower_bound(at, at + count, low - plan_.raise.taps + 1);
    const auto* const to = std::lower_bound(at, at + count, high);
    return std::array{static_cast<int>(from - at), static_cast<int>(to - at)};
  };
  const auto [x0, x1] = range(fan ? m_.fan_x : plan_.raise.x, tile_.x - plan_.sheets.border, m_.width,
                              touched.x0 + tile_.ring_x, touched.x1 + tile_.ring_x);
  const auto [y0, y1] = range(fan ? m_.fan_y : plan_.raise.y, tile_.y - plan_.sheets.border, m_.height,
                              touched.y0 + tile_.ring_y, touched.y1 + tile_.ring_y);
  return {x0, y0, x1, y1};
}

// Makes the pixels of sheet k out of its samples.
void SheetSource::raise_sheet(int64_t k, const PixelRect& touched) {
  // As a fan spreads, others would want samples beyond the tile's (gap_scales()).
  if (!raised(k)) {
    filled_[k] = false;
    return;
  }
  if (plan_.raise.fan.taps > 0) {
    const RaiseFan& fan = plan_.raise.fan;
    const double scale = fan.scale(static_cast<double>(k));
    fan_axis(fan, fan.x, scale, tile_.x - plan_.sheets.border, m_.width, m_.fan_x);
    fan_axis(fan, fan.y, scale, tile_.y - plan_.sheets.border, m_.height, m_.fan_y);
  }
  const RaiseAxis &across = plan_.raise.fan.taps > 0 ? m_.fan_x : plan_.raise.x,
                  &down = plan_.raise.fan.taps > 0 ? m_.fan_y : plan_.raise.y;
  const PixelRect now = whole_vectors(raised_pixels(touched));
  const PixelRect before = std::exchange(plane_touched_[k], now);
  clear_around(before, now, m_.plane_origin(k, 0), m_.plane_pitch);
  if (now.empty()) return;
  RaiseArgs r;
  r.taps = plan_.raise.taps;
  r.sheet = m_.samples.data(), r.sheet_pitch = m_.sample_pitch;
  r.plane = m_.plane_origin(k, 0), r.plane_pitch = m_.plane_pitch;
  r.x0 = now.x0, r.x1 = std::min(now.x1, m_.width), r.y0 = now.y0, r.y1 = now.y1;
  const size_t x = tile_.x - plan_.sheets.border - across.first,
               y = tile_.y - plan_.sheets.border - down.first;
  r.sample_x = across.sample.data() + x, r.weight_x = across.weight.data() + x;
  r.sample_y = down.sample.data() + y, r.weight_y = down.weight.data() + y;
  r.weight_pitch_x = across.pitch, r.weight_pitch_y = down.pitch;
  r.origin_x = tile_.ring_x, r.origin_y = tile_.ring_y;
  r.scratch = m_.scratch.data(), r.scratch_pitch = m_.sample_pitch + 32;
  loops_.raise(r);
}

} // namespace bccsplat
