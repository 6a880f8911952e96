// SPDX-License-Identifier: Apache-2.0
// From the values of neighbouring pixels of a sheet to the colour and opacity of their segments: by one entry
// of the table, or by the table's integrals. The file is included once per target.
#include "splat/sheet/sheet_pixels-inl.h"

#if defined(BCCSPLAT_SHEET_CLASSIFY_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef BCCSPLAT_SHEET_CLASSIFY_INL
#undef BCCSPLAT_SHEET_CLASSIFY_INL
#else
#define BCCSPLAT_SHEET_CLASSIFY_INL
#endif

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
#if HWY_TARGET != HWY_SCALAR
namespace {

using VI = hn::Vec<hn::RebindToSigned<D>>;

// The part of the segments inside the domain, sheets.
struct Extent {
  V begin, weight;
};

struct SegmentColor {
  V red, green, blue, absorbed, value;
  V depth; // optical; of ByIntegrals
  V front; // share of the front half in what is absorbed; of ByIntegrals
};

// A passage of the opacity through 1/2: the opacities before and behind, and the part of the segment between.
struct Passage {
  V before, after, begin, weight;
};

// How much of what a segment of one extinction absorbs its front half does.
HWY_INLINE V FrontShare(V absorbed) {
  const V one = Set(1.0f), left = hn::Max(hn::Sub(one, absorbed), hn::Zero(d));
  return hn::Div(one, hn::Add(one, hn::Sqrt(left)));
}

// One entry stands for the segment.
struct ByEntry {
  const ClassTable& table;
  V low, scale, top;
  VI first, last;
  explicit ByEntry(const ClassTable& t)
      : table(t), low(Set(t.low)), scale(Set(t.scale)), top(Set(static_cast<float>(t.size() - 1))),
        first(hn::Set(di, t.first_visible - 1)), last(hn::Set(di, t.last_visible + 1)) {}

  HWY_INLINE void begin() const {} // the first of the sheets at some pixels
  // Classifies the segments of pixels below `stop`; false when none absorbs. Sets those that do.
  HWY_INLINE bool operator()(const SheetArgs& s, const Pixels& px, V alpha, V enter, V leave, V stop,
                             Extent& extent, SegmentColor& out, M& active) const {
    out.value = px.value();
    const auto index =
        hn::NearestInt(hn::Min(hn::Max(hn::Mul(hn::Sub(out.value, low), scale), hn::Zero(d)), top));
    const M visible = hn::RebindMask(d, hn::And(hn::Gt(index, first), hn::Lt(index, last)));
    extent.begin = hn::Max(Set(s.segment.begin()), enter);
    extent.weight = hn::Max(hn::Sub(hn::Min(Set(s.segment.end()), leave), extent.begin), hn::Zero(d));
    active = hn::And(hn::And(visible, hn::Lt(alpha, stop)), hn::Gt(extent.weight, hn::Zero(d)));
    if (s.hole) active = hn::And(active, px.solid());
    if (hn::AllFalse(d, active)) return false;
    const V one = Set(1.0f);
    const M whole = s.classes.whole ? hn::And(active, hn::Eq(extent.weight, one)) : hn::Lt(one, one);
    if (!hn::AllFalse(d, whole)) LookUp(s.classes.whole, index, out.red, out.green, out.blue, out.absorbed);
    const M partial = hn::AndNot(whole, active);
    if (!hn::AllFalse(d, partial)) {
      V extinction;
      LookUp(table.entry.data(), index, out.red, out.green, out.blue, extinction);
      const V part = Absorbed(hn::Mul(hn::Mul(extinction, extent.weight), hn::LoadU(d, s.pixel.path + px.p)));
      out.absorbed = hn::AllFalse(d, whole) ? part : hn::IfThenElse(whole, out.absorbed, part);
    }
    return true;
  }
  HWY_INLINE Passage passage(const Extent& extent, V before, V after, V /*depth_at*/) const {
    return {before, after, extent.begin, extent.weight};
  }
  HWY_INLINE V front_share(const SegmentColor& segment) const { return FrontShare(segment.absorbed); }
};

// As classify_segment.
struct ByIntegrals {
  // A value and the integrals up to it, as two terms of which the second is small.
  struct Point {
    V e;
    V red, green, blue, extinction, red_rest, green_rest, blue_rest, extinction_rest;
    V moment, moment_rest;
  };

  const ClassTable& table;
  const ValueIntegrals& t;
  bool with_value;
  V share; // what all extinctions are multiplied by
  VI last;
  V low, scale, top;
  V first_visible, last_visible; // nothing absorbs below and above
  // What the front half of the last segments absorbs, and its length in sheets.
  mutable V front = hn::Zero(d), front_weight = hn::Zero(d);
  mutable Point last_point; // where the last segment of these pixels ended
  mutable bool known_point = false;
  ByIntegrals(const ClassTable& c, bool value, float of = 1)
      : table(c), t(c.integrals), with_value(value), share(Set(of)), last(hn::Set(di, c.integrals.last())),
        low(Set(c.low)), scale(Set(c.scale)), top(Set(static_cast<float>(c.size() - 1))),
        first_visible(Set(c.integrals.first)), last_visible(Set(c.integrals.last_end)) {}

  HWY_INLINE void begin() const { known_point = false; }
  HWY_INLINE V clamped(V e) const { return hn::Min(hn::Max(e, Set(-1.0f)), hn::Add(top, Set(2.0f))); }
  HWY_INLINE VI within(V interval) const {
    return hn::Min(hn::Max(hn::ConvertTo(di, interval), hn::Zero(di)), last);
  }
  HWY_INLINE VI below(V e) const { return within(hn::Add(hn::Floor(clamped(e)), Set(1.0f))); }

  HWY_INLINE Point look_up(V e) const {
    Point p;
    p.e = e;
    const VI interval = below(e);
    const V base = hn::ConvertTo(d, hn::Max(hn::Sub(interval, hn::Set(di, 1)), hn::Zero(di)));
    const V inside = hn::Sub(e, base);
    const VI three = hn::Add(hn::Add(interval, interval), interval);
    LookUp(t.part.data(), three, p.red, p.green, p.blue, p.extinction);
    V red, green, blue, mean;
    LookUp(t.part.data() + 2, three, red, green, blue, mean);
    p.red_rest = hn::Mul(inside, red), p.green_rest = hn::Mul(inside, green);
    p.blue_rest = hn::Mul(inside, blue), p.extinction_rest = hn::Mul(inside, mean);
    if (t.split) {
      V extinction;
      LookUp(t.part.data() + 1, three, red, green, blue, extinction);
      p.red_rest = hn::Add(p.red_rest, red), p.green_rest = hn::Add(p.green_rest, green);
      p.blue_rest = hn::Add(p.blue_rest, blue), p.extinction_rest = hn::Add(p.extinction_rest, extinction);
    }
    p.moment = p.moment_rest = hn::Zero(d);
    if (with_value) {
      V unused1, unused2;
      LookUp(t.moment.data(), interval, p.moment, p.moment_rest, unused1, unused2);
      const V middle = hn::MulAdd(Set(0.5f), inside, base);
      p.moment_rest = hn::MulAdd(middle, hn::Mul(inside, mean), p.moment_rest);
    }
    return p;
  }

  // As classify_half; out.value in entries.
  HWY_INLINE void classify_half(const Point& a, const Point& b, V length, M active, SegmentColor& out) const {
    const V zero = hn::Zero(d), span = hn::Sub(b.e, a.e), middle = hn::Mul(Set(0.5f), hn::Add(a.e, b.e));
    const auto difference = [](V from, V from_rest, V to, V to_rest)
                                HWY_ATTR { return hn::Add(hn::Sub(to, from), hn::Sub(to_rest, from_rest)); };
    const M flat = hn::Lt(hn::Abs(span), Set(1.0f));
    const V sum = difference(a.extinction, a.extinction_rest, b.extinction, b.extinction_rest);
    V extinction = hn::Max(hn::Div(sum, hn::IfThenElse(flat, Set(1.0f), span)), zero);
    const M some = hn::Gt(extinction, zero);
    const V over = hn::Div(Set(1.0f), hn::IfThenElse(some, sum, Set(1.0f)));
    const auto color = [&](V from, V from_rest, V to, V to_rest) HWY_ATTR {
      return hn::Max(hn::Mul(difference(from, from_rest, to, to_rest), over), zero);
    };
    out.red = color(a.red, a.red_rest, b.red, b.red_rest);
    out.green = color(a.green, a.green_rest, b.green, b.green_rest);
    out.blue = color(a.blue, a.blue_rest, b.blue, b.blue_rest);
    out.value = middle;
    if (with_value) {
      const V mean = hn::Mul(difference(a.moment, a.moment_rest, b.moment, b.moment_rest), over);
      const V inside = hn::Min(hn::Max(mean, hn::Min(a.e, b.e)), hn::Max(a.e, b.e));
      out.value = hn::IfThenElse(flat, middle, inside);
    }
    if (!hn::AllFalse(d, hn::And(flat, hn::And(active, hn::Gt(length, zero))))) {
      V red, green, blue, entry;
      LookUp(table.entry.data(), hn::NearestInt(hn::Min(hn::Max(middle, zero), top)), red, green, blue,
             entry);
      out.red = hn::IfThenElse(flat, red, out.red), out.green = hn::IfThenElse(flat, green, out.green),
      out.blue = hn::IfThenElse(flat, blue, out.blue), extinction = hn::IfThenElse(flat, entry, extinction);
    }
    out.depth = hn::Mul(extinction, length);
    out.absorbed = Absorbed(out.depth);
  }

  HWY_INLINE bool operator()(const SheetArgs& s, const Pixels& px, V alpha, V enter, V leave, V stop,
                             Extent& extent, SegmentColor& out, M& active) const {
    const V zero = hn::Zero(d), half = Set(0.5f), k = Set(s.segment.k);
    extent.begin = hn::Max(Set(s.segment.begin()), enter);
    extent.weight = hn::Max(hn::Sub(hn::Min(Set(s.segment.end()), leave), extent.begin), zero);
    active = hn::And(hn::Lt(alpha, stop), hn::Gt(extent.weight, zero));
    if (s.hole) active = hn::And(active, px.solid());
    if (hn::AllFalse(d, active)) return false;
    const V sample = hn::LoadU(d, s.field.value + px.at);
    const auto halfway = [&](const Halfway& h, M known) HWY_ATTR {
      const auto term = [&](size_t n) HWY_ATTR { return hn::LoadU(d, h.plane[n] + px.at); };
      const V sum =
          hn::MulAdd(Set(h.weight[0]), term(0),
                     hn::MulAdd(Set(h.weight[1]), term(1),
                                hn::MulAdd(Set(h.weight[2]), term(2), hn::Mul(Set(h.weight[3]), term(3)))));
      return hn::IfThenElse(known, sum, sample);
    };
    const V known = Set(s.halves.known);
    const V before = halfway(s.halves.front, hn::Ge(Set(s.segment.k - 1), hn::Sub(enter, known))),
            behind = halfway(s.halves.back, hn::Le(Set(s.segment.k + 1), hn::Add(leave, known)));
    const auto entry = [&](V value) HWY_ATTR {
      return hn::Mul(hn::Sub(hn::Add(Set(s.field.base), value), low), scale);
    };
    const V e = entry(sample), e_front = entry(before), e_back = entry(behind);
    // Beside the domain a ray begins at infinity.
    const V t0 = hn::IfThenElseZero(active, hn::Sub(extent.begin, k)),
            t1 = hn::Add(t0, hn::IfThenElseZero(active, extent.weight)), tm = hn::Min(hn::Max(zero, t0), t1);
    V e0 = e_front, em = e, e1 = e_back;
    // Some rays begin or end in the segment.
    if (!hn::AllTrue(d, hn::And(hn::Le(t0, hn::Neg(half)), hn::Ge(t1, half)))) {
      const auto value = [&](V at) HWY_ATTR {
        const V rise = hn::IfThenElse(hn::Lt(at, zero), hn::Sub(e, e_front), hn::Sub(e_back, e));
        const V inside = hn::MulAdd(hn::Add(at, at), rise, e);
        return hn::IfThenElse(hn::Le(at, hn::Neg(half)), e_front,
                              hn::IfThenElse(hn::Ge(at, half), e_back, inside));
      };
      e0 = value(t0), em = value(tm), e1 = value(t1);
    }
    const V low_e = hn::Min(hn::Min(e0, em), e1), high_e = hn::Max(hn::Max(e0, em), e1);
    active = hn::And(active, hn::And(hn::Ge(high_e, first_visible), hn::Le(low_e, last_visible)));
    if (hn::AllFalse(d, active)) return false;
    const VI from = below(low_e), to = hn::Max(from, within(hn::Ceil(clamped(high_e))));
    const auto visible =
        hn::Lt(hn::GatherIndex(di, t.next_visible.data(), from), hn::Add(to, hn::Set(di, 1)));
    active = hn::And(active, hn::RebindMask(d, visible));
    if (hn::AllFalse(d, active)) return false;
    // The segment before this one often ended where this one begins.
    const Point a = known_point && hn::AllTrue(d, hn::Eq(e0, last_point.e)) ? last_point : look_up(e0);
    const Point m = look_up(em);
    last_point = look_up(e1), known_point = true;
    const V path = hn::Mul(share, hn::LoadU(d, s.pixel.path + px.p));
    front_weight = hn::Sub(tm, t0);
    SegmentColor first, second;
    classify_half(a, m, hn::Mul(front_weight, path), active, first);
    classify_half(m, last_point, hn::Mul(hn::Sub(t1, tm), path), active, second);
    front = first.absorbed;
    const V rest = hn::Mul(hn::Sub(Set(1.0f), front), second.absorbed);
    out.absorbed = hn::Add(front, rest);
    out.depth = hn::Add(first.depth, second.depth);
    active = hn::And(active, hn::Gt(out.absorbed, zero));
    if (hn::AllFalse(d, active)) return false;
    const V over = hn::Div(Set(1.0f), hn::IfThenElse(active, out.absorbed, Set(1.0f)));
    const V fa = hn::Mul(front, over), fb = hn::Mul(rest, over);
    out.front = fa;
    const auto join = [&](V x, V y) HWY_ATTR { return hn::MulAdd(fa, x, hn::Mul(fb, y)); };
    out.red = join(first.red, second.red), out.green = join(first.green, second.green);
    out.blue = join(first.blue, second.blue);
    out.value = hn::MulAdd(join(first.value, second.value), Set(1 / table.scale), low);
    return true;
  }

  HWY_INLINE Passage passage(const Extent& extent, V before, V after, V depth_at) const {
    const V middle = hn::MulAdd(hn::Sub(Set(1.0f), before), front, before);
    const M early = hn::Ge(middle, depth_at);
    return {hn::IfThenElse(early, before, middle), hn::IfThenElse(early, middle, after),
            hn::IfThenElse(early, extent.begin, hn::Add(extent.begin, front_weight)),
            hn::IfThenElse(early, front_weight, hn::Sub(extent.weight, front_weight))};
  }
  HWY_INLINE V front_share(const SegmentColor& segment) const { return segment.front; }
};

} // namespace
#endif
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();
#endif
