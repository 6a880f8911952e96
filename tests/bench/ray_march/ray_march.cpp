// SPDX-License-Identifier: Apache-2.0
// The marcher's packets through Highway: one body, compiled for every target, the best chosen at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tests/bench/ray_march/ray_march.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <hwy/contrib/math/math-inl.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "tests/bench/ray_march/ray_march.h"
#include "tests/bench/ray_march/ray_march_packet.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat::bench {
namespace HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR
bool MarchBlock(const MarchPacketArgs&, int, int) { return false; } // the caller takes the reference
#else

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, 16>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;
constexpr D d;
using DI = hn::RebindToSigned<D>;
constexpr DI di;
using VI = hn::Vec<DI>;

HWY_INLINE V set(float x) { return hn::Set(d, x); }
HWY_INLINE V lerp(V a, V b, V f) { return hn::MulAdd(f, hn::Sub(b, a), a); }
HWY_INLINE V Dot(V ax, V ay, V az, V bx, V by, V bz) {
  return hn::MulAdd(ax, bx, hn::MulAdd(ay, by, hn::Mul(az, bz)));
}
HWY_INLINE V InverseRoot(V x) {
  const V y = hn::ApproximateReciprocalSqrt(x);
  return hn::Mul(y, hn::NegMulAdd(hn::Mul(hn::Mul(set(0.5f), x), y), y, set(1.5f)));
}

struct Vector3 {
  V x, y, z;
};

// Values of the grid around a packet of points.
struct Fetch {
  const MarchPacketArgs& a;
  V fx, fy, fz;
  VI index;

  HWY_INLINE Fetch(const MarchPacketArgs& args, const Vector3& p) : a(args) {
    const VI x = hn::ConvertTo(di, p.x), y = hn::ConvertTo(di, p.y), z = hn::ConvertTo(di, p.z);
    fx = hn::Sub(p.x, hn::ConvertTo(d, x)), fy = hn::Sub(p.y, hn::ConvertTo(d, y)),
    fz = hn::Sub(p.z, hn::ConvertTo(d, z));
    index = hn::Add(hn::Add(x, hn::Set(di, a.origin)),
                    hn::Add(hn::Mul(y, hn::Set(di, a.row)), hn::Mul(z, hn::Set(di, a.plane))));
  }
  // Samples index + shift and the one after it: one gather of 64 bits each.
  HWY_INLINE void pair(int shift, V& first, V& second) const {
    const hn::Repartition<int64_t, D> d64;
    const hn::Half<DI> dh;
    const VI bytes = hn::ShiftLeft<2>(hn::Add(index, hn::Set(di, shift)));
    const auto* base = reinterpret_cast<const int64_t*>(a.value);
    const V low = hn::BitCast(d, hn::GatherOffset(d64, base, hn::PromoteTo(d64, hn::LowerHalf(dh, bytes))));
    const V high = hn::BitCast(d, hn::GatherOffset(d64, base, hn::PromoteTo(d64, hn::UpperHalf(dh, bytes))));
    first = hn::ConcatEven(d, high, low), second = hn::ConcatOdd(d, high, low);
  }
  HWY_INLINE V single(int shift) const {
    return hn::GatherIndex(d, a.value, hn::Add(index, hn::Set(di, shift)));
  }
  HWY_INLINE V along_x(int shift) const {
    V first, second;
    pair(shift, first, second);
    return lerp(first, second, fx);
  }
};

struct Sample {
  V value;
  std::array<V, 8> corner; // x + 2 y + 4 z
};

HWY_INLINE Sample interpolate(const Fetch& f) {
  Sample s;
  f.pair(0, s.corner[0], s.corner[1]), f.pair(f.a.row, s.corner[2], s.corner[3]);
  f.pair(f.a.plane, s.corner[4], s.corner[5]), f.pair(f.a.plane + f.a.row, s.corner[6], s.corner[7]);
  const V near = lerp(lerp(s.corner[0], s.corner[1], f.fx), lerp(s.corner[2], s.corner[3], f.fx), f.fy);
  const V far = lerp(lerp(s.corner[4], s.corner[5], f.fx), lerp(s.corner[6], s.corner[7], f.fx), f.fy);
  s.value = lerp(near, far, f.fz);
  return s;
}

// Twice the interpolated central differences.
HWY_INLINE Vector3 differences(const Fetch& f, const Sample& s) {
  const int row = f.a.row, plane = f.a.plane;
  Vector3 g;
  const auto x_row = [&](int shift, V c0, V c1) HWY_ATTR {
    const V before = f.single(shift - 1), after = f.single(shift + 2);
    return hn::Sub(lerp(c1, after, f.fx), lerp(before, c0, f.fx));
  };
  g.x = lerp(lerp(x_row(0, s.corner[0], s.corner[1]), x_row(row, s.corner[2], s.corner[3]), f.fy),
             lerp(x_row(plane, s.corner[4], s.corner[5]), x_row(plane + row, s.corner[6], s.corner[7]), f.fy),
             f.fz);
  const V r00 = lerp(s.corner[0], s.corner[1], f.fx), r10 = lerp(s.corner[2], s.corner[3], f.fx);
  const V r01 = lerp(s.corner[4], s.corner[5], f.fx), r11 = lerp(s.corner[6], s.corner[7], f.fx);
  const V y_before = lerp(f.along_x(-row), f.along_x(plane - row), f.fz);
  const V y_after = lerp(f.along_x(2 * row), f.along_x(plane + 2 * row), f.fz);
  g.y = hn::Sub(lerp(lerp(r10, r11, f.fz), y_after, f.fy), lerp(y_before, lerp(r00, r01, f.fz), f.fy));
  const V z_before = lerp(f.along_x(-plane), f.along_x(row - plane), f.fy);
  const V z_after = lerp(f.along_x(2 * plane), f.along_x(row + 2 * plane), f.fy);
  g.z = hn::Sub(lerp(lerp(r01, r11, f.fy), z_after, f.fz), lerp(z_before, lerp(r00, r10, f.fy), f.fz));
  return g;
}

// x^n for whole n by squaring, else by logarithms; x in [0, 1].
HWY_INLINE V Power(V x, float power) {
  if (power >= 0 && power <= 1024 && power == std::floor(power)) {
    V result = set(1.0f);
    for (int n = static_cast<int>(power); n > 0; n >>= 1) {
      if (n & 1) result = hn::Mul(result, x);
      x = hn::Mul(x, x);
    }
    return result;
  }
  return hn::Exp(d, hn::Mul(set(power), hn::Log(d, hn::Max(x, set(1e-30f)))));
}

// splat/shade/light.h for a packet.
HWY_INLINE void light(const MarchPacketArgs& a, const Vector3& g, const Vector3& to_viewer, Vector3& color) {
  const V square = Dot(g.x, g.y, g.z, g.x, g.y, g.z);
  const M surface = hn::Gt(square, set(1e-36f));
  const V inverse = InverseRoot(hn::IfThenElse(surface, square, set(1.0f)));
  Vector3 scale{set(a.ambient), set(a.ambient), set(a.ambient)};
  Vector3 shine{hn::Zero(d), hn::Zero(d), hn::Zero(d)};
  for (int n = 0; n < a.light_count; ++n) {
    const MarchLight& l = a.lights[n];
    V facing, glint;
    if (l.headlight) {
      facing = hn::Mul(hn::Abs(Dot(g.x, g.y, g.z, to_viewer.x, to_viewer.y, to_viewer.z)), inverse);
      glint = facing;
    } else {
      const V lx = set(l.direction[0]), ly = set(l.direction[1]), lz = set(l.direction[2]);
      facing = hn::Mul(hn::Abs(Dot(g.x, g.y, g.z, lx, ly, lz)), inverse);
      const V hx = hn::Add(lx, to_viewer.x), hy = hn::Add(ly, to_viewer.y), hz = hn::Add(lz, to_viewer.z);
      const V over = InverseRoot(hn::Max(Dot(hx, hy, hz, hx, hy, hz), set(1e-12f)));
      glint = hn::Mul(hn::Mul(hn::Abs(Dot(g.x, g.y, g.z, hx, hy, hz)), inverse), over);
    }
    const V one = set(1.0f);
    facing = hn::Mul(hn::IfThenElse(surface, hn::Min(facing, one), one), set(a.diffuse));
    glint = hn::Mul(hn::IfThenElseZero(surface, Power(hn::Min(glint, one), a.shininess)), set(a.specular));
    scale.x = hn::MulAdd(facing, set(l.color[0]), scale.x),
    shine.x = hn::MulAdd(glint, set(l.color[0]), shine.x);
    scale.y = hn::MulAdd(facing, set(l.color[1]), scale.y),
    shine.y = hn::MulAdd(glint, set(l.color[1]), shine.y);
    scale.z = hn::MulAdd(facing, set(l.color[2]), scale.z),
    shine.z = hn::MulAdd(glint, set(l.color[2]), shine.z);
  }
  color.x = hn::MulAdd(color.x, scale.x, shine.x), color.y = hn::MulAdd(color.y, scale.y, shine.y),
  color.z = hn::MulAdd(color.z, scale.z, shine.z);
}

// A packet of rays; lane n is pixel (n % 4, n / 4) of it.
struct Packet {
  const MarchPacketArgs& a;
  Vector3 origin, direction, inverse, to_viewer;
  V enter, leave, path; // sheet numbers; length per sheet step

  HWY_INLINE Packet(const MarchPacketArgs& args, int x, int y) : a(args) {
    alignas(64) float column[16], line[16];
    for (int n = 0; n < 16; ++n)
      column[n] = static_cast<float>(x + n % 4), line[n] = static_cast<float>(y + n / 4);
    const V i = hn::Load(d, column), j = hn::Load(d, line);
    const auto across = [&](size_t axis)
                            HWY_ATTR { return hn::MulAdd(i, set(a.ex[axis]), hn::Mul(j, set(a.ey[axis]))); };
    const auto start = [&](size_t axis, V dir) HWY_ATTR {
      if (a.perspective) return hn::MulAdd(set(a.depth), dir, set(a.eye[axis]));
      return hn::Add(set(a.eye[axis]), across(axis));
    };
    const auto heading = [&](size_t axis) HWY_ATTR {
      return a.perspective ? hn::Add(set(a.ez[axis]), across(axis)) : set(a.ez[axis]);
    };
    direction = {heading(0), heading(1), heading(2)};
    origin = {start(0, direction.x), start(1, direction.y), start(2, direction.z)};
    enter = set(a.first_sheet), leave = set(1e9f);
    if (a.perspective) enter = hn::Max(enter, set(-a.depth));
    inverse.x = clip(origin.x, direction.x, a.end[0]);
    inverse.y = clip(origin.y, direction.y, a.end[1]);
    inverse.z = clip(origin.z, direction.z, a.end[2]);
    const V square = Dot(direction.x, direction.y, direction.z, direction.x, direction.y, direction.z);
    path = hn::Sqrt(square);
    const V back = hn::Neg(hn::Div(set(1.0f), path));
    to_viewer = {hn::Mul(back, direction.x), hn::Mul(back, direction.y), hn::Mul(back, direction.z)};
  }

  // Cuts the rays at the two ends of an axis; returns 1 / direction.
  HWY_INLINE V clip(V o, V dir, float end) {
    const V tiny = set(1e-20f);
    const V safe = hn::IfThenElse(hn::Lt(hn::Abs(dir), tiny), tiny, dir);
    const V over = hn::Div(set(1.0f), safe);
    const V k0 = hn::Mul(hn::Neg(o), over), k1 = hn::Mul(hn::Sub(set(end), o), over);
    enter = hn::Max(enter, hn::Min(k0, k1));
    leave = hn::Min(leave, hn::Max(k0, k1));
    return over;
  }
  HWY_INLINE Vector3 at(V k) const {
    const V zero = hn::Zero(d);
    k = hn::Min(hn::Max(k, enter), leave);
    return {hn::Min(hn::Max(hn::MulAdd(k, direction.x, origin.x), zero), set(a.end[0])),
            hn::Min(hn::Max(hn::MulAdd(k, direction.y, origin.y), zero), set(a.end[1])),
            hn::Min(hn::Max(hn::MulAdd(k, direction.z, origin.z), zero), set(a.end[2]))};
  }

  // Whether one of `active` stands in a cell that shows something at sheet k. `until`: the answer holds for
  // the sheets before it.
  HWY_INLINE bool look(float k, M active, float& until) const {
    const Vector3 p = at(set(k));
    const V over = set(1.0f / MarchGrid::cell_edge);
    const VI cx = hn::ConvertTo(di, hn::Mul(p.x, over)), cy = hn::ConvertTo(di, hn::Mul(p.y, over)),
             cz = hn::ConvertTo(di, hn::Mul(p.z, over));
    const auto nearest = [&](VI c, int cells) HWY_ATTR { return hn::Min(c, hn::Set(di, cells - 1)); };
    const VI x = nearest(cx, a.cells[0]), y = nearest(cy, a.cells[1]), z = nearest(cz, a.cells[2]);
    const VI cell =
        hn::Add(x, hn::Mul(hn::Set(di, a.cells[0]), hn::Add(y, hn::Mul(hn::Set(di, a.cells[1]), z))));
    const VI free =
        hn::And(hn::GatherOffset(di, reinterpret_cast<const int32_t*>(a.distance), cell), hn::Set(di, 255));
    // The box of cells around that are like this one.
    const V around = hn::ConvertTo(d, hn::Max(hn::Sub(free, hn::Set(di, 1)), hn::Zero(di)));
    const V edge = set(static_cast<float>(MarchGrid::cell_edge));
    const auto beyond = [&](VI c, V o, V inv) HWY_ATTR {
      const V base = hn::ConvertTo(d, c);
      const V low = hn::Mul(edge, hn::Sub(base, around));
      const V high = hn::Mul(edge, hn::Add(base, hn::Add(around, set(1.0f))));
      return hn::Max(hn::Mul(hn::Sub(low, o), inv), hn::Mul(hn::Sub(high, o), inv));
    };
    V exit = hn::Min(beyond(x, origin.x, inverse.x),
                     hn::Min(beyond(y, origin.y, inverse.y), beyond(z, origin.z, inverse.z)));
    // Rays that have not begun stand still until they do.
    exit = hn::Max(exit, hn::Min(hn::Sub(enter, set(0.5f)), leave));
    const M shows = hn::And(active, hn::RebindMask(d, hn::Eq(free, hn::Zero(di))));
    const bool any = !hn::AllFalse(d, shows);
    const M counted = any ? shows : active;
    const V next = hn::IfThenElse(counted, exit, set(any ? -1e9f : 1e9f));
    until = any ? hn::GetLane(hn::MaxOfLanes(d, next)) : hn::GetLane(hn::MinOfLanes(d, next));
    return any;
  }
};

HWY_INLINE void classify(const MarchPacketArgs& a, V value, V& r, V& g, V& b, V& extinction) {
  const V top = set(static_cast<float>(a.entries - 1));
  const VI index = hn::NearestInt(
      hn::Min(hn::Max(hn::Mul(hn::Sub(value, set(a.table_low)), set(a.table_scale)), hn::Zero(d)), top));
  alignas(64) int32_t entry[16];
  alignas(64) float looked_up[64];
  hn::Store(index, di, entry);
  for (size_t n = 0; n < hn::Lanes(d); ++n)
    std::memcpy(looked_up + 4 * n, a.table + 4 * static_cast<size_t>(entry[n]), 4 * sizeof(float));
  hn::LoadInterleaved4(d, looked_up, r, g, b, extinction);
}

struct Result {
  V red, green, blue, alpha;
};

Result Composite(const Packet& rays, float from, float to) {
  const MarchPacketArgs& a = rays.a;
  const V one = set(1.0f), half = set(0.5f), stop = set(a.stop);
  Result out{hn::Zero(d), hn::Zero(d), hn::Zero(d), hn::Zero(d)};
  const M hits = hn::Lt(rays.enter, rays.leave);
  float until = -1e9f;
  for (float k = from; k <= to; k += 1) {
    const M open = hn::And(hits, hn::And(hn::Lt(out.alpha, stop), hn::Gt(hn::Add(rays.leave, half), set(k))));
    if (hn::AllFalse(d, open)) break;
    if (a.distance && k >= until && !rays.look(k, open, until)) {
      k = std::max(k, std::ceil(until) - 1);
      continue;
    }
    const Fetch fetch(a, rays.at(set(k)));
    const Sample sample = interpolate(fetch);
    V red, green, blue, extinction;
    classify(a, sample.value, red, green, blue, extinction);
    const V weight =
        hn::Sub(hn::Min(hn::Add(set(k), half), rays.leave), hn::Max(hn::Sub(set(k), half), rays.enter));
    const V depth =
        hn::IfThenElseZero(open, hn::Mul(hn::Mul(extinction, hn::Max(weight, hn::Zero(d))), rays.path));
    if (hn::AllFalse(d, hn::Gt(depth, hn::Zero(d)))) continue;
    if (a.shading) {
      Vector3 color{red, green, blue};
      light(a, differences(fetch, sample), rays.to_viewer, color);
      red = color.x, green = color.y, blue = color.z;
    }
    const V f = hn::Mul(hn::Sub(one, out.alpha), hn::Sub(one, hn::Exp(d, hn::Neg(depth))));
    out.red = hn::MulAdd(f, red, out.red), out.green = hn::MulAdd(f, green, out.green);
    out.blue = hn::MulAdd(f, blue, out.blue), out.alpha = hn::Add(out.alpha, f);
  }
  return out;
}

Result Isosurface(const Packet& rays, float from, float to) {
  const MarchPacketArgs& a = rays.a;
  const V one = set(1.0f), iso = set(a.iso_value);
  Result out{hn::Zero(d), hn::Zero(d), hn::Zero(d), hn::Zero(d)};
  const M hits = hn::Lt(rays.enter, rays.leave);
  float until = -1e9f;
  bool known = false; // the values at k - 1
  V before = hn::Zero(d);
  for (float k = from; k <= to + 1; k += 1) {
    const M open =
        hn::And(hits, hn::And(hn::Eq(out.alpha, hn::Zero(d)), hn::Gt(hn::Add(rays.leave, one), set(k))));
    if (hn::AllFalse(d, open)) break;
    if (a.distance && k >= until && !rays.look(k, open, until)) {
      k = std::max(k, std::ceil(until) - 1);
      known = false;
      continue;
    }
    const V k_before = set(k - 1), k_now = set(k);
    if (!known) before = interpolate(Fetch(a, rays.at(k_before))).value;
    known = true;
    const Sample sample = interpolate(Fetch(a, rays.at(k_now)));
    const V now = sample.value;
    const M below = hn::Lt(before, iso);
    const M found = hn::And(open, hn::Xor(below, hn::Lt(now, iso)));
    if (!hn::AllFalse(d, found)) {
      // Regula falsi, kept from sticking to one end (Illinois).
      V k0 = hn::Min(hn::Max(k_before, rays.enter), rays.leave),
        k1 = hn::Min(hn::Max(k_now, rays.enter), rays.leave);
      V v0 = hn::Sub(before, iso), v1 = hn::Sub(now, iso);
      V hit = k1;
      for (int step = 0; step < a.refinements; ++step) {
        const V span = hn::Sub(v1, v0);
        const V safe = hn::IfThenElse(hn::Gt(hn::Abs(span), set(1e-30f)), span, one);
        hit = hn::NegMulAdd(hn::Div(hn::Sub(k1, k0), safe), v0, k0);
        if (step + 1 == a.refinements) break;
        const V v = hn::Sub(interpolate(Fetch(a, rays.at(hit))).value, iso);
        const M first = hn::Not(hn::Xor(hn::Lt(v, hn::Zero(d)), hn::Lt(v0, hn::Zero(d))));
        v1 = hn::IfThenElse(first, hn::Mul(v1, set(0.5f)), v);
        k1 = hn::IfThenElse(first, k1, hit);
        v0 = hn::IfThenElse(first, v, hn::Mul(v0, set(0.5f)));
        k0 = hn::IfThenElse(first, hit, k0);
      }
      Vector3 color{set(a.iso_color[0]), set(a.iso_color[1]), set(a.iso_color[2])};
      if (a.shading) {
        const Fetch at_hit(a, rays.at(hit));
        light(a, differences(at_hit, interpolate(at_hit)), rays.to_viewer, color);
      }
      out.red = hn::IfThenElse(found, color.x, out.red),
      out.green = hn::IfThenElse(found, color.y, out.green);
      out.blue = hn::IfThenElse(found, color.z, out.blue), out.alpha = hn::IfThenElse(found, one, out.alpha);
    }
    before = now;
  }
  return out;
}

// The block of march_block^2 pixels at (x, y).
bool MarchBlock(const MarchPacketArgs& a, int x0, int y0) {
  const int rows = static_cast<int>(hn::Lanes(d)) / 4;
  for (int y = y0; y < std::min(y0 + march_block, a.height); y += rows)
    for (int x = x0; x < std::min(x0 + march_block, a.width); x += 4) {
      const Packet rays(a, x, y);
      const M hits = hn::Lt(rays.enter, rays.leave);
      alignas(64) float pixels[64] = {};
      if (!hn::AllFalse(d, hits)) {
        const float first = hn::GetLane(hn::MinOfLanes(d, hn::IfThenElse(hits, rays.enter, set(1e9f))));
        const float last = hn::GetLane(hn::MaxOfLanes(d, hn::IfThenElse(hits, rays.leave, set(-1e9f))));
        const float from = std::ceil(first - 0.5f), to = std::floor(last + 0.5f);
        const Result r = a.isosurface ? Isosurface(rays, from, to) : Composite(rays, from, to);
        hn::StoreInterleaved4(r.red, r.green, r.blue, r.alpha, d, pixels);
      }
      for (int j = 0; j < rows && y + j < a.height; ++j)
        std::memcpy(a.rgba + static_cast<size_t>(y + j) * a.row_floats + 4 * static_cast<size_t>(x),
                    pixels + 16 * j, sizeof(float) * 4 * static_cast<size_t>(std::min(4, a.width - x)));
    }
  return true;
}

#endif

} // namespace HWY_NAMESPACE
} // namespace bccsplat::bench
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat::bench {
HWY_EXPORT(MarchBlock);

void ray_march(const MarchScene& scene, const MarchOptions& options, const Context& context, Image& image) {
  const MarchGrid& grid = *scene.grid;
  const Slice domain = grid_domain(grid);
  const SheetView view =
      make_view(domain, resolve_camera(scene.camera), image.width, image.height, options.step);
  const ClassTable table = march_table(scene, options);
  MarchPacketArgs a;
  const auto narrow = [](const Vec3& v) {
    return std::array<float, 3>{static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
  };
  a.value = grid.value.data();
  a.origin = static_cast<int>(grid.origin), a.row = static_cast<int>(grid.row),
  a.plane = static_cast<int>(grid.plane);
  a.distance = options.skip ? scene.distance->data() : nullptr;
  a.cells = grid.cells;
  a.end = narrow(domain.domain_end);
  a.perspective = view.perspective;
  a.eye = narrow(view.eye), a.ex = narrow(view.ex), a.ey = narrow(view.ey), a.ez = narrow(view.ez);
  a.depth = static_cast<float>(view.depth);
  a.first_sheet = view.perspective ? static_cast<float>(view.first_sheet()) - 0.5f : -1e9f;
  a.width = image.width, a.height = image.height;
  a.rgba = image.rgba.pixels, a.row_floats = image.rgba.row_floats;
  a.table = table.entry.front().data(), a.entries = table.size();
  a.table_low = table.low, a.table_scale = table.scale;
  a.isosurface = options.mode == RenderMode::isosurface;
  a.iso_value = static_cast<float>(options.iso_value),
  a.iso_color = narrow(scene.function.color(options.iso_value));
  a.stop = static_cast<float>(options.opacity_stop);
  a.shading = options.shading;
  a.ambient = static_cast<float>(scene.lights.ambient), a.diffuse = static_cast<float>(scene.lights.diffuse);
  a.specular = static_cast<float>(scene.lights.specular),
  a.shininess = static_cast<float>(scene.lights.shininess);
  for (const Light& l : scene.lights.lights) {
    const bool headlight = dot(l.direction, l.direction) == 0;
    a.lights[static_cast<size_t>(a.light_count++)] = {
        headlight, headlight ? std::array<float, 3>{} : narrow(normalized(l.direction)), narrow(l.color)};
  }
  const int nx = (image.width + march_block - 1) / march_block,
            ny = (image.height + march_block - 1) / march_block;
  std::atomic<bool> vectors{true};
  context.tasks.parallel_for(static_cast<uint64_t>(nx) * static_cast<uint64_t>(ny), [&](uint64_t n) {
    const int x = static_cast<int>(n % static_cast<uint64_t>(nx)),
              y = static_cast<int>(n / static_cast<uint64_t>(nx));
    if (!HWY_DYNAMIC_DISPATCH(MarchBlock)(a, x * march_block, y * march_block)) vectors = false;
  });
  if (!vectors) ray_march_reference(scene, options, image);
}

} // namespace bccsplat::bench
#endif
