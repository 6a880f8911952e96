// SPDX-License-Identifier: Apache-2.0
// The reference loops are slow and read like the formulae of loops.h; tests compare the SIMD loops with them.
#include <algorithm>
#include <cmath>

#include "base/grid.h"
#include "splat/loop/loops.h"

namespace bccsplat {
namespace {

float polynomial(const std::array<float, RadialKernel::max_terms>& a, int terms, float u) {
  float sum = 0;
  for (int j = terms - 1; j >= 0; --j) sum = sum * u + a[j];
  return sum;
}

void splat(const SplatArgs& s) {
  for (size_t n = 0; n < s.count; ++n) {
    const SplatRecord& p = s.record[n];
    for (int g = 0; g < s.groups; ++g)
      for (int row = std::max(0, -p.y); row < std::min(s.rows, s.height - p.y); ++row)
        for (int column = std::max(0, -p.x); column < std::min(s.columns, s.width - p.x); ++column)
          for (int l = 0; l < 4; ++l) {
            const size_t slot = 4 * g + l;
            const float di = static_cast<float>(column) - p.fx - p.lateral_x * s.lanes->delta[slot];
            const float dj = static_cast<float>(row) - p.fy - p.lateral_y * s.lanes->delta[slot];
            const float dk = s.lanes->offset[slot] - p.z;
            const float u = 1 - s.depth2 * dk * dk - di * (s.lanes->xx[slot] * di + s.lanes->xy[slot] * dj) -
                            s.lanes->yy[slot] * dj * dj;
            if (!(u > 0)) continue;
            const size_t at = g * s.group_floats + plane_index(p.x + column, p.y + row, s.pitch) * 4 + l;
            s.ring[0][at] += p.c * polynomial(s.kernel->a, s.kernel->terms, u);
            if (!s.ring[1]) continue;
            const float slope = p.c * polynomial(s.kernel->slope, s.kernel->terms - 1, u);
            s.ring[1][at] += slope * di;
            s.ring[2][at] += slope * dj;
            s.ring[3][at] += slope * dk;
          }
  }
}

// The pixels of the tile that may look at `count` samples from `sample` on, counted from the fan's foot.
void fan_window(const FanArgs& fan, size_t gap, float per, float foot, int sample, int count, int& begin,
                int& end) {
  const float low = static_cast<float>(sample - fan.around) * per,
              high = static_cast<float>(sample + count + fan.around) * per;
  const float near = fan.inverse_near[gap], far = fan.inverse_far[gap];
  begin = static_cast<int>(std::max(std::floor(std::min(low * near, low * far) + foot), -1e8f)) - fan.border;
  end =
      static_cast<int>(std::min(std::ceil(std::max(high * near, high * far) + foot), 1e8f)) + 1 + fan.border;
}

TransformCounts transform(const TransformArgs& t) {
  const BrickAxes& f = *t.axes;
  TransformCounts counts;
  for (size_t n = 0; n < t.count; ++n) {
    const unsigned cell = (t.position[n] >> 2 & 3u) | (t.position[n] >> 4 & 12u) | (t.position[n] >> 6 & 48u);
    if (!(t.cells >> cell & 1)) {
      ++counts.invisible;
      continue;
    }
    const auto x = static_cast<float>(t.position[n] & 15), y = static_cast<float>(t.position[n] >> 4 & 15),
               z = static_cast<float>(t.position[n] >> 8 & 15);
    const auto affine = [&](const std::array<float, 4>& a) {
      return a[0] * x + a[1] * y + (a[2] * z + a[3]);
    };
    const float depth = affine(f.dk);
    const float whole = std::floor(depth);
    const int64_t gap = f.k + static_cast<int64_t>(whole);
    if (gap < t.first_gap || gap > t.last_gap) continue;
    const size_t s = gap - t.gaps.base;
    float foot_x = affine(f.di), foot_y = affine(f.dj), lateral_x = 0, lateral_y = 0;
    if (!t.isotropic) {
      lateral_x = affine(f.dX), lateral_y = affine(f.dY);
      foot_x += lateral_x * (t.gaps.lateral[s] - f.m);
      foot_y += lateral_y * (t.gaps.lateral[s] - f.m);
    }
    const float start_x = std::floor(foot_x - t.gaps.half_x[s]) + 1,
                start_y = std::floor(foot_y - t.gaps.half_y[s]) + 1;
    if (!(std::fabs(start_x) < 1e8f && std::fabs(start_y) < 1e8f)) continue; // far outside any picture
    const int px = f.i - t.tile.x + static_cast<int>(start_x),
              py = f.j - t.tile.y + static_cast<int>(start_y);
    if (px >= t.tile.width || py >= t.tile.height || px + t.gaps.columns[s] <= 0 || py + t.gaps.rows[s] <= 0)
      continue;
    const int32_t* const rect = t.tile.fan ? t.tile.fan->rect + 4 * s : nullptr;
    if (rect && (px >= rect[2] || py >= rect[3] || px + t.gaps.columns[s] <= rect[0] ||
                 py + t.gaps.rows[s] <= rect[1]))
      continue;
    if (t.tile.open_sum) {
      int x0 = px - t.tile.around, x1 = px + t.gaps.columns[s] + t.tile.around;
      int y0 = py - t.tile.around, y1 = py + t.gaps.rows[s] + t.tile.around;
      if (t.tile.fan) {
        const FanArgs& a = *t.tile.fan;
        fan_window(a, s, a.per_x, a.foot_x, px - a.sample_foot_x, t.gaps.columns[s], x0, x1);
        fan_window(a, s, a.per_y, a.foot_y, py - a.sample_foot_y, t.gaps.rows[s], y0, y1);
      }
      const int width = t.tile.fan ? t.tile.fan->width : t.tile.width,
                height = t.tile.fan ? t.tile.fan->height : t.tile.height;
      x0 = std::clamp(x0, 0, width), x1 = std::clamp(x1, 0, width);
      y0 = std::clamp(y0, 0, height), y1 = std::clamp(y1, 0, height);
      const auto sum = [&](int row, int column) { return t.tile.open_sum[row * (width + 1) + column]; };
      if (sum(y1, x1) - sum(y1, x0) - sum(y0, x1) + sum(y0, x0) == 0) {
        ++counts.occluded;
        continue;
      }
    }
    *t.bin_end[s & t.bin_mask]++ = {
        foot_x - start_x, foot_y - start_y, depth - whole, t.coefficient[n], px, py, lateral_x, lateral_y};
    ++counts.accepted;
  }
  return counts;
}

void extract(const ExtractArgs& e) {
  for (int y = 0; y < e.height; ++y)
    for (int x = 0; x < e.width; ++x) {
      float& sum = e.ring[plane_index(x, y, e.pitch) * 4 + e.lane];
      e.plane[plane_index(x, y, e.plane_pitch)] = sum;
      sum = 0;
    }
}

} // namespace

const SplatLoops& reference_loops() {
  static constexpr SplatLoops loops{splat, transform, extract, raise_reference, blend_reference};
  return loops;
}

} // namespace bccsplat
