// SPDX-License-Identifier: Apache-2.0
// A packet of sixteen rays (as many as a vector has lanes) and where they are. The file is included once per
// target.
#include <algorithm>
#include <cmath>

#include <hwy/highway.h>

#include "tests/bench/ray_march/ray_march.h"
#include "tests/bench/ray_march/ray_march_packet.h"

#if defined(BCCSPLAT_MARCH_PACKET_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef BCCSPLAT_MARCH_PACKET_INL
#undef BCCSPLAT_MARCH_PACKET_INL
#else
#define BCCSPLAT_MARCH_PACKET_INL
#endif

HWY_BEFORE_NAMESPACE();
namespace bccsplat::bench {
namespace HWY_NAMESPACE {
#if HWY_TARGET != HWY_SCALAR

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

  // Which rays are in a cell that shows something at sheet k. The answer holds for the sheets before `until`;
  // of a surface one sheet more is looked at, for it may be crossed on the way out of the cell.
  HWY_INLINE M look(float k, V& until) const {
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
    const V exit = hn::Min(beyond(x, origin.x, inverse.x),
                           hn::Min(beyond(y, origin.y, inverse.y), beyond(z, origin.z, inverse.z)));
    const M shows = hn::RebindMask(d, hn::Eq(free, hn::Zero(di)));
    // Rays that have not begun stand still until they do.
    until = hn::Max(exit, hn::Min(hn::Sub(enter, set(0.5f)), leave));
    until = hn::Add(until, hn::IfThenElseZero(shows, set(a.isosurface ? 1.0f : 0.0f)));
    return shows;
  }
};

// What of the rays' way may show something, asked sheet by sheet.
template<bool lane_by_lane> struct Skips {
  const Packet& rays;
  M shows{};
  V until = set(-1e9f);

  HWY_INLINE explicit Skips(const Packet& packet) : rays(packet), shows(hn::Lt(hn::Zero(d), hn::Zero(d))) {}

  // Which of the rays in `open` have to be looked at on sheet k; if none has, k goes on to the last sheet
  // before one of them does.
  HWY_INLINE M wanted(M open, float& k) {
    if (!rays.a.distance) return open;
    const M stale = hn::Le(until, set(k));
    if (!hn::AllFalse(d, hn::And(open, stale))) {
      V next;
      const M now = rays.look(k, next);
      // What is known of the others still holds.
      shows = hn::Or(hn::And(stale, now), hn::AndNot(stale, shows));
      until = hn::IfThenElse(stale, next, until);
      if (!lane_by_lane) { // all of them as long as one
        const M counted = hn::And(open, shows);
        if (!hn::AllFalse(d, counted)) {
          until = hn::MaxOfLanes(d, hn::IfThenElse(counted, until, set(-1e9f)));
          shows = open;
        }
      }
    }
    const M out = hn::And(open, shows);
    if (hn::AllFalse(d, out)) {
      const float next = hn::GetLane(hn::MinOfLanes(d, hn::IfThenElse(open, until, set(1e9f))));
      k = std::max(k, std::ceil(next) - 1);
    }
    return out;
  }
};

#endif
} // namespace HWY_NAMESPACE
} // namespace bccsplat::bench
HWY_AFTER_NAMESPACE();

#endif
