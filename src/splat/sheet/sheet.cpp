// SPDX-License-Identifier: Apache-2.0
// The reference form of sheet.h, which reads like the formulae; sheet_simd.cpp has the fast one.
#include "splat/sheet/sheet.h"

#include <algorithm>
#include <cmath>

#include "shade/absorption.h"

namespace bccsplat {
namespace {

// Takes the kernel's ripple off the analytic sums gi, gj and gk at a pixel of the tile.
void take_ripple_off(const SheetArgs& s, int x, int y, float value, float& gi, float& gj, float& gk) {
  const SheetRipple& r = s.analytic.ripple;
  if (!r.sums) return;
  Vec3 place;
  for (size_t a = 0; a < 3; ++a)
    place[a] = static_cast<float>(s.tile.x + x) * r.per_x[a] +
               (r.at[a] + static_cast<float>(s.tile.y + y) * r.per_y[a]);
  const Vec3 ripple = r.sums->nearest_gradient(place);
  for (size_t a = 0; a < 3; ++a) {
    const float of_value = value * static_cast<float>(ripple[a]);
    gi -= of_value * r.sum_i[a], gj -= of_value * r.sum_j[a], gk -= of_value * r.sum_k[a];
  }
}

} // namespace

float segment_weight(const SheetArgs& s, size_t p) {
  const float w = std::min(s.segment.end(), s.pixel.leave[p]) - std::max(s.segment.begin(), s.pixel.enter[p]);
  return std::max(w, 0.0f);
}

Vec3 world_gradient(const SheetArgs& s, int x, int y, float quarters) {
  const std::ptrdiff_t at = s.tile.sample(x, y);
  const SheetDifferences& by = s.differences;
  float gi, gj, gk;
  if (by.neighbours > 0) {
    const auto slope = [&](std::ptrdiff_t step) {
      const float* v = s.field.value + at;
      const float near = v[step] - v[-step];
      return by.neighbours == 2 ? (8 * near - (v[2 * step] - v[-2 * step])) / 12 : near / 2;
    };
    gi = slope(1), gj = slope(s.tile.plane_pitch);
    gk = by.depth_scale * (by.after[at] - by.before[at]);
    if (by.neighbours == 2) gk += by.depth_scale2 * (by.after2[at] - by.before2[at]);
    if (quarters != 0) {
      const auto change = [&](std::ptrdiff_t step) {
        return (by.after[at + step] - by.after[at - step] - (by.before[at + step] - by.before[at - step])) /
               4;
      };
      const float t = quarters / 4;
      gi += t * change(1), gj += t * change(s.tile.plane_pitch);
      gk += t * (by.after[at] - 2 * s.field.value[at] + by.before[at]);
    }
    const float slant_x = s.basis.slant_x + static_cast<float>(s.tile.x + x) * s.basis.slant_per_x;
    const float slant_y = s.basis.slant_y + static_cast<float>(s.tile.y + y) * s.basis.slant_per_y;
    gk -= slant_x * gi + slant_y * gj;
  } else {
    gi = s.analytic.i[at], gj = s.analytic.j[at], gk = s.analytic.k[at];
    take_ripple_off(s, x, y, s.field.value[at], gi, gj, gk);
  }
  gi *= s.basis.unit, gj *= s.basis.unit, gk *= s.basis.unit;
  Vec3 g;
  for (size_t a = 0; a < 3; ++a)
    g[a] = (gi * s.basis.x[a] + (gj * s.basis.y[a] + gk * s.basis.z[a])) / s.basis.enlarged;
  return g;
}

Segment classify_pixel(const SheetArgs& s, size_t p, std::ptrdiff_t at, float share) {
  Segment out;
  out.begin = std::max(s.segment.begin(), s.pixel.enter[p]);
  out.weight = segment_weight(s, p);
  out.value = s.paint.value ? s.paint.value[p] : s.field.base + s.field.value[at];
  const ClassTable& table = *s.classes.table;
  const float path = share * s.pixel.path[p];
  if (!s.halves.preintegrated) {
    const auto& [red, green, blue, extinction] = table.entry[table.index(out.value)];
    out.color = {red, green, blue};
    out.depth = extinction * out.weight * path, out.absorbed = absorbed(out.depth);
    return out;
  }
  if (!(out.weight > 0)) return out;
  const auto halfway = [&](const Halfway& h, bool known) {
    if (!known) return s.field.value[at];
    return h.weight[0] * h.plane[0][at] +
           (h.weight[1] * h.plane[1][at] + (h.weight[2] * h.plane[2][at] + h.weight[3] * h.plane[3][at]));
  };
  const float front = halfway(s.halves.front, s.segment.k - 1 >= s.pixel.enter[p] - s.halves.known),
              back = halfway(s.halves.back, s.segment.k + 1 <= s.pixel.leave[p] + s.halves.known);
  const auto entry = [&](float value) { return (s.field.base + value - table.low) * table.scale; };
  const float e = entry(s.field.value[at]), e_front = entry(front), e_back = entry(back);
  // Where the segment begins and ends, and the border of its halves, in sheets from k.
  const float t0 = out.begin - s.segment.k, t1 = t0 + out.weight, tm = std::clamp(0.0f, t0, t1);
  const auto value = [&](float t) {
    if (t <= -0.5f) return e_front;
    if (t >= 0.5f) return e_back;
    return t < 0 ? e + 2 * t * (e - e_front) : e + 2 * t * (e_back - e);
  };
  out.front_weight = tm - t0;
  const SegmentClass c =
      classify_segment(table, {value(t0), value(tm), value(t1)}, {out.front_weight * path, (t1 - tm) * path});
  out.color = c.color, out.absorbed = c.absorbed, out.front = c.front, out.depth = c.depth;
  if (c.absorbed > 0) out.value = c.value;
  return out;
}

Shading light_segment(const SheetArgs& s, int x, int y, const Segment& segment, float added) {
  const size_t p = s.tile.pixel(x, y);
  const Vec3 viewer{static_cast<double>(s.pixel.view_x[p]), static_cast<double>(s.pixel.view_y[p]),
                    static_cast<double>(s.pixel.view_z[p])};
  const double value = s.field.value[s.tile.sample(x, y)];
  std::array<float, lights_at_most> of_lights{};
  LightThrough through;
  if (s.paint.ambient) through.ambient = s.paint.ambient[p];
  if (s.paint.lights) {
    for (size_t n = 0; n < s.shading.lights->lights.size(); ++n)
      of_lights[n] = s.paint.lights[n * s.paint.light_floats + p];
    through.lights = std::span(of_lights).first(s.shading.lights->lights.size());
  }
  const auto light = [&](float quarters) {
    return shade(*s.shading.lights, world_gradient(s, x, y, quarters), viewer, value, through);
  };
  if (!s.differences.halves || !(added > lit_in_halves)) return light(0);
  const float apart = std::min(added / lit_in_halves - 1, 1.0f);
  const Shading front = light(-apart), back = light(apart);
  const float of_front = s.halves.preintegrated ? segment.front / segment.absorbed
                                                : 1 / (1 + std::sqrt(std::max(1 - segment.absorbed, 0.0f)));
  const double share = of_front;
  return {share * front.scale + (1 - share) * back.scale,
          share * front.highlight + (1 - share) * back.highlight};
}

namespace {

int composite_sheet(const SheetArgs& s) {
  int closed = 0;
  for (int y = 0; y < s.tile.height; ++y)
    for (int x = 0; x < s.tile.width; ++x) {
      const size_t p = s.tile.pixel(x, y);
      float& alpha = s.pixel.alpha[p];
      if (alpha >= s.classes.stop || (s.hole && s.hole[p])) continue;
      const std::ptrdiff_t at = s.tile.sample(x, y);
      const Segment segment = classify_pixel(s, p, at);
      if (!(segment.absorbed > 0)) continue;
      const float f = (1 - alpha) * segment.absorbed;
      Shading lit{{1, 1, 1}, {}};
      if (s.shading.on) lit = light_segment(s, x, y, segment, f);
      s.pixel.red[p] +=
          f * (segment.color[0] * static_cast<float>(lit.scale[0]) + static_cast<float>(lit.highlight[0]));
      s.pixel.green[p] +=
          f * (segment.color[1] * static_cast<float>(lit.scale[1]) + static_cast<float>(lit.highlight[1]));
      s.pixel.blue[p] +=
          f * (segment.color[2] * static_cast<float>(lit.scale[2]) + static_cast<float>(lit.highlight[2]));
      const float before = alpha;
      alpha += f;
      if (const float depth_at = s.classes.depth_at; before < depth_at && alpha >= depth_at) {
        // The transmittance falls exponentially through the part of the segment inside the domain, or that of
        // its halves where the opacity passes that.
        const float middle = before + (1 - before) * segment.front;
        float from = before, to = alpha, begin = segment.begin, weight = segment.weight;
        if (s.halves.preintegrated && middle >= depth_at)
          to = middle, weight = segment.front_weight;
        else if (s.halves.preintegrated)
          from = middle, begin += segment.front_weight, weight -= segment.front_weight;
        const float part =
            to < 1 ? std::log((1 - depth_at) / (1 - from)) / std::log((1 - to) / (1 - from)) : 0.0f;
        s.pixel.depth[p] = begin + part * weight;
      }
      if (s.pixel.value) s.pixel.value[p] += f * segment.value;
      if (s.pixel.time) s.pixel.time[p] += f * s.time_at(x, y);
      if (alpha >= s.classes.stop) ++closed;
    }
  return closed;
}

int composite(std::span<const SheetArgs> sheets) {
  int closed = 0;
  for (const SheetArgs& s : sheets) closed += composite_sheet(s);
  return closed;
}

void integrate(const SheetArgs& s) {
  for (int y = 0; y < s.tile.height; ++y)
    for (int x = 0; x < s.tile.width; ++x) {
      const size_t p = s.tile.pixel(x, y);
      if (s.hole && s.hole[p]) continue;
      const float value = s.field.above_air + s.field.value[s.tile.sample(x, y)];
      const float part = value * segment_weight(s, p) * s.pixel.path[p];
      s.pixel.red[p] += part;
      if (!s.pixel.time) continue;
      s.pixel.alpha[p] += std::fabs(part);
      s.pixel.time[p] += std::fabs(part) * s.time_at(x, y);
    }
}

// Returns whether a curve from d0 to d1 with the slopes s0 and s1 at its ends (per sheet) may reach 0 inside.
bool may_graze(float d0, float d1, float s0, float s1) {
  const float side = d0 < 0 ? 1.0f : -1.0f; // seen from below
  d0 *= side, d1 *= side, s0 *= side, s1 *= side;
  const float at = d1 - d0 - s1, over = s0 - s1; // the tangents meet at at / over
  return s0 > 0 && s1 < 0 && at > 0 && at < over && d0 * over + s0 * at >= 0;
}

size_t crossings(const CrossingArgs& c) {
  size_t count = 0;
  for (int y = 0; y < c.height; ++y)
    for (int x = 0; x < c.width; ++x) {
      const std::ptrdiff_t at = plane_offset(x, y, c.plane_pitch);
      const size_t p = plane_index(x, y, c.pitch);
      if (!(c.alpha[p] < c.stop)) continue;
      for (int n = 0; n < c.count; ++n) {
        const float k = c.k + static_cast<float>(n);
        if (!(k >= c.enter[p] && k - 1 <= c.leave[p])) continue;
        const auto value = [&](int sheet) { return c.plane[n + sheet][at]; };
        const float v0 = value(1), v1 = value(2), d0 = v0 - c.target, d1 = v1 - c.target;
        const bool crosses = (d0 < 0) != (d1 < 0);
        if (!crosses && !may_graze(d0, d1, 0.5f * (v1 - value(0)), 0.5f * (value(3) - v0))) continue;
        c.found[count++] = {static_cast<uint16_t>(x), static_cast<uint16_t>(y), static_cast<uint8_t>(n),
                            !crosses};
      }
    }
  return count;
}

void maximum(const SheetArgs& s) {
  for (int y = 0; y < s.tile.height; ++y)
    for (int x = 0; x < s.tile.width; ++x) {
      const size_t p = s.tile.pixel(x, y);
      if ((s.hole && s.hole[p]) || !(segment_weight(s, p) > 0)) continue;
      const float value = s.field.base + s.field.value[s.tile.sample(x, y)];
      if (!(value > s.pixel.red[p])) continue;
      s.pixel.red[p] = value;
      s.pixel.depth[p] = s.segment.k;
    }
}

} // namespace

const SheetLoops& reference_sheet_loops() {
  static constexpr SheetLoops loops{composite, integrate, crossings, maximum};
  return loops;
}

} // namespace bccsplat
