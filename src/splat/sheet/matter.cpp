// SPDX-License-Identifier: Apache-2.0
// The reference form of matter.h, which reads like the formulae; matter_simd.cpp has the fast one.
#include "splat/sheet/matter.h"

#include <algorithm>
#include <cmath>

#include "shade/absorption.h"

namespace bccsplat {
namespace {

void absorb(const SheetArgs& s, float weight, const MatterPlanes& out) {
  const PixelRect seen = s.tile.seen.within(s.tile.width, s.tile.height);
  for (int y = seen.y0; y < seen.y1; ++y)
    for (int x = seen.x0; x < seen.x1; ++x) {
      const size_t p = s.tile.pixel(x, y);
      if (s.pixel.alpha[p] >= s.classes.stop || (s.hole && s.hole[p])) continue;
      const std::ptrdiff_t at = s.tile.sample(x, y);
      Segment segment = classify_pixel(s, p, at, weight);
      const float depth = segment.depth;
      if (!(depth > 0)) continue;
      if (s.paint.red) segment.color = {s.paint.red[p], s.paint.green[p], s.paint.blue[p]};
      Shading lit{{1, 1, 1}, {}};
      if (s.shading.on) lit = light_segment(s, x, y, segment, (1 - s.pixel.alpha[p]) * segment.absorbed);
      const auto light = [&](float color, size_t c) {
        return depth * (color * static_cast<float>(lit.scale[c]) + static_cast<float>(lit.highlight[c]));
      };
      out.red[p] += light(segment.color[0], 0), out.green[p] += light(segment.color[1], 1);
      out.blue[p] += light(segment.color[2], 2);
      out.depth[p] += depth;
      if (out.value) out.value[p] += depth * segment.value;
      if (out.time) out.time[p] += depth * s.time_at(x, y);
    }
}

// Returns the opacity per optical depth that each group has in the sheet.
std::array<float, 2> shares(float a, float b, TrailCombine combine) {
  if (combine == TrailCombine::interleaved)
    return {a > 0 ? absorbed(a) / (2 * a) : 0, b > 0 ? absorbed(b) / (2 * b) : 0};
  const float sum = a + b;
  const float share = absorbed(sum) / sum;
  return {share, share};
}

int join(const JoinArgs& j) {
  int closed = 0;
  for (int y = 0; y < j.height; ++y)
    for (int x = 0; x < j.width; ++x) {
      const size_t p = plane_index(x, y, j.pitch);
      const float before = j.pixel.alpha[p];
      const auto of = [&](float* MatterPlanes::*plane, size_t group) {
        return j.group[group] ? (j.group[group]->*plane)[p] : 0.0f;
      };
      const float a = of(&MatterPlanes::depth, 0), b = of(&MatterPlanes::depth, 1);
      if (before >= j.stop || !(a + b > 0)) continue;
      const auto [of_a, of_b] = shares(a, b, j.combine);
      const float fa = (1 - before) * of_a, fb = (1 - before) * of_b;
      const auto add = [&](float* out, float* MatterPlanes::*plane) {
        if (out) out[p] += fa * of(plane, 0) + fb * of(plane, 1);
      };
      add(j.pixel.red, &MatterPlanes::red), add(j.pixel.green, &MatterPlanes::green);
      add(j.pixel.blue, &MatterPlanes::blue);
      add(j.pixel.value, &MatterPlanes::value), add(j.pixel.time, &MatterPlanes::time);
      const float after = before + (fa * a + fb * b);
      j.pixel.alpha[p] = after;
      if (before < j.depth_at && after >= j.depth_at) {
        const float begin = std::max(j.k - j.front, j.pixel.enter[p]),
                    end = std::min(j.k + 0.5f, j.pixel.leave[p]);
        const float part =
            after < 1 ? std::log((1 - j.depth_at) / (1 - before)) / std::log((1 - after) / (1 - before))
                      : 0.0f;
        j.pixel.depth[p] = begin + part * std::max(end - begin, 0.0f);
      }
      if (after >= j.stop) ++closed;
    }
  return closed;
}

std::array<float, 2> mix(const MixArgs& m) {
  std::array<float, 2> range{0, 0};
  for (int y = 0; y < m.height; ++y)
    for (int x = 0; x < m.width; ++x) {
      const std::ptrdiff_t at = plane_offset(x, y, m.pitch);
      float sum = 0;
      for (size_t i = 0; i < m.plane.size(); ++i) sum += m.weight[i] * m.plane[i][at];
      m.out[at] = sum;
      range = {std::min(range[0], sum), std::max(range[1], sum)};
    }
  return range;
}

} // namespace

void pair_up(const MatterPair& pair, const MatterPlanes& into) {
  constexpr float opaque = 64; // an optical depth: floats know no more
  for (int y = 0; y < pair.height; ++y)
    for (int x = 0; x < pair.width; ++x) {
      const size_t p = plane_index(x, y, pair.pitch);
      const auto of = [&](float* MatterPlanes::*plane, size_t group) {
        return pair.group[group] ? (pair.group[group]->*plane)[p] : 0.0f;
      };
      const float a = of(&MatterPlanes::depth, 0), b = of(&MatterPlanes::depth, 1);
      if (!(a + b > 0)) continue;
      const auto [of_a, of_b] = shares(a, b, pair.combine);
      const float alpha = of_a * a + of_b * b;
      const float depth = alpha < 1 ? std::min(-std::log1p(-alpha), opaque) : opaque;
      const auto add = [&, of_a = of_a, of_b = of_b](float* MatterPlanes::*plane) {
        if (float* const out = into.*plane)
          out[p] += depth / alpha * (of_a * of(plane, 0) + of_b * of(plane, 1));
      };
      add(&MatterPlanes::red), add(&MatterPlanes::green), add(&MatterPlanes::blue);
      add(&MatterPlanes::value), add(&MatterPlanes::time);
      into.depth[p] += depth;
    }
}

const MatterLoops& reference_matter_loops() {
  static constexpr MatterLoops loops{absorb, join, mix};
  return loops;
}

} // namespace bccsplat
