// SPDX-License-Identifier: Apache-2.0
// The marcher's packets through Highway: one body, compiled for every target, the best chosen at run time.
// What differs between interpolations is the field: a class that gives values and gradients to a packet of
// points.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tests/bench/ray_march/ray_march.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "tests/bench/ray_march/march_packet-inl.h"
#include "tests/bench/ray_march/march_shade-inl.h"
#include "tests/bench/ray_march/march_tricubic-inl.h"
#include "tests/bench/ray_march/march_trilinear-inl.h"
#include "tests/bench/ray_march/ray_march.h"
#include "tests/bench/ray_march/ray_march_packet.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat::bench {
namespace HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR || HWY_HAVE_SCALABLE
bool MarchBlock(const MarchPacketArgs&, int, int) { return false; } // the caller takes the reference
bool MarchPoints(const MarchPacketArgs&, const MarchPoint*, MarchFieldValue*, size_t) { return false; }
#else

struct Result {
  V red, green, blue, alpha;
};

template<class Field> Result Composite(const Packet& rays, float from, float to) {
  const MarchPacketArgs& a = rays.a;
  const V one = set(1.0f), half = set(0.5f), stop = set(a.stop);
  Result out{hn::Zero(d), hn::Zero(d), hn::Zero(d), hn::Zero(d)};
  const M hits = hn::Lt(rays.enter, rays.leave);
  Field field(a);
  Skips<Field::lane_by_lane> skips(rays);
  for (float k = from; k <= to; k += 1) {
    const M open = hn::And(hits, hn::And(hn::Lt(out.alpha, stop), hn::Gt(hn::Add(rays.leave, half), set(k))));
    if (hn::AllFalse(d, open)) break;
    const M wanted = skips.wanted(open, k);
    if (hn::AllFalse(d, wanted)) continue;
    const Vector3 p = rays.at(set(k));
    V red, green, blue, extinction;
    classify(a, field.value(p, wanted), red, green, blue, extinction);
    const V weight =
        hn::Sub(hn::Min(hn::Add(set(k), half), rays.leave), hn::Max(hn::Sub(set(k), half), rays.enter));
    const V depth =
        hn::IfThenElseZero(wanted, hn::Mul(hn::Mul(extinction, hn::Max(weight, hn::Zero(d))), rays.path));
    const M absorbs = hn::Gt(depth, hn::Zero(d));
    if (hn::AllFalse(d, absorbs)) continue;
    if (a.shading) {
      Vector3 color{red, green, blue};
      light(a, field.gradient(p, absorbs), rays.to_viewer, color);
      red = color.x, green = color.y, blue = color.z;
    }
    const V f = hn::Mul(hn::Sub(one, out.alpha), hn::Sub(one, hn::Exp(d, hn::Neg(depth))));
    out.red = hn::MulAdd(f, red, out.red), out.green = hn::MulAdd(f, green, out.green);
    out.blue = hn::MulAdd(f, blue, out.blue), out.alpha = hn::Add(out.alpha, f);
  }
  return out;
}

// Where the rays in `found` pass the iso value between two sheets, by regula falsi that is kept from sticking
// to one end (Illinois). The values there are relative to it.
template<class Field> V Crossing(const Packet& rays, Field& field, M found, V k0, V k1, V v0, V v1) {
  const MarchPacketArgs& a = rays.a;
  k0 = hn::Min(hn::Max(k0, rays.enter), rays.leave), k1 = hn::Min(hn::Max(k1, rays.enter), rays.leave);
  for (int step = 1;; ++step) {
    const V span = hn::Sub(v1, v0);
    const V safe = hn::IfThenElse(hn::Gt(hn::Abs(span), set(1e-30f)), span, set(1.0f));
    const V hit = hn::NegMulAdd(hn::Div(hn::Sub(k1, k0), safe), v0, k0);
    if (step == a.refinements) return hit;
    const V v = hn::Sub(field.value_alone(rays.at(hit), found), set(a.iso_value));
    const M first = hn::Not(hn::Xor(hn::Lt(v, hn::Zero(d)), hn::Lt(v0, hn::Zero(d))));
    v1 = hn::IfThenElse(first, hn::Mul(v1, set(0.5f)), v);
    k1 = hn::IfThenElse(first, k1, hit);
    v0 = hn::IfThenElse(first, v, hn::Mul(v0, set(0.5f)));
    k0 = hn::IfThenElse(first, hit, k0);
  }
}

template<class Field> Result Isosurface(const Packet& rays, float from, float to) {
  const MarchPacketArgs& a = rays.a;
  const V one = set(1.0f), iso = set(a.iso_value);
  Result out{hn::Zero(d), hn::Zero(d), hn::Zero(d), hn::Zero(d)};
  const M hits = hn::Lt(rays.enter, rays.leave), none = hn::Lt(one, hn::Zero(d));
  Field field(a);
  Skips<Field::lane_by_lane> skips(rays);
  M known = none; // whose values at k - 1
  V before = hn::Zero(d);
  for (float k = from; k <= to + 1; k += 1) {
    const M open =
        hn::And(hits, hn::And(hn::Eq(out.alpha, hn::Zero(d)), hn::Gt(hn::Add(rays.leave, one), set(k))));
    if (hn::AllFalse(d, open)) break;
    const M wanted = skips.wanted(open, k);
    if (hn::AllFalse(d, wanted)) {
      known = none;
      continue;
    }
    const M unknown = hn::AndNot(known, wanted);
    if (!hn::AllFalse(d, unknown))
      before = hn::IfThenElse(unknown, field.value_alone(rays.at(set(k - 1)), unknown), before);
    const V now = field.value_alone(rays.at(set(k)), wanted);
    const M found = hn::And(wanted, hn::Xor(hn::Lt(before, iso), hn::Lt(now, iso)));
    if (!hn::AllFalse(d, found)) {
      const V hit = Crossing(rays, field, found, set(k - 1), set(k), hn::Sub(before, iso), hn::Sub(now, iso));
      Vector3 color{set(a.iso_color[0]), set(a.iso_color[1]), set(a.iso_color[2])};
      if (a.shading) {
        const Vector3 p = rays.at(hit);
        (void)field.value(p, found);
        light(a, field.gradient(p, found), rays.to_viewer, color);
      }
      out.red = hn::IfThenElse(found, color.x, out.red),
      out.green = hn::IfThenElse(found, color.y, out.green);
      out.blue = hn::IfThenElse(found, color.z, out.blue), out.alpha = hn::IfThenElse(found, one, out.alpha);
    }
    before = now, known = wanted;
  }
  return out;
}

template<class Field> void Block(const MarchPacketArgs& a, int x0, int y0) {
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
        const Result r = a.isosurface ? Isosurface<Field>(rays, from, to) : Composite<Field>(rays, from, to);
        hn::StoreInterleaved4(r.red, r.green, r.blue, r.alpha, d, pixels);
      }
      for (int j = 0; j < rows && y + j < a.height; ++j)
        std::memcpy(a.rgba + (y + j) * a.row_floats + 4 * static_cast<size_t>(x), pixels + 16 * j,
                    sizeof(float) * 4 * std::min(4, a.width - x));
    }
}

// The block of march_block^2 pixels at (x, y).
bool MarchBlock(const MarchPacketArgs& a, int x, int y) {
  a.cubic ? Block<Tricubic>(a, x, y) : Block<Trilinear>(a, x, y);
  return true;
}

template<class Field>
void Points(const MarchPacketArgs& a, const MarchPoint* points, MarchFieldValue* out, size_t count) {
  Field field(a);
  const size_t lanes = hn::Lanes(d);
  for (size_t first = 0; first < count; first += lanes) {
    const size_t n = std::min(lanes, count - first);
    alignas(64) float at[3][16] = {}, found[4][16];
    for (size_t i = 0; i < n; ++i)
      for (size_t axis = 0; axis < 3; ++axis) at[axis][i] = points[first + i][axis];
    const Vector3 p{hn::Load(d, at[0]), hn::Load(d, at[1]), hn::Load(d, at[2])};
    const M wanted = hn::FirstN(d, n);
    hn::Store(field.value(p, wanted), d, found[0]);
    const Vector3 g = field.gradient(p, wanted);
    hn::Store(g.x, d, found[1]), hn::Store(g.y, d, found[2]), hn::Store(g.z, d, found[3]);
    for (size_t i = 0; i < n; ++i) out[first + i] = {found[0][i], {found[1][i], found[2][i], found[3][i]}};
  }
}

bool MarchPoints(const MarchPacketArgs& a, const MarchPoint* points, MarchFieldValue* out, size_t count) {
  a.cubic ? Points<Tricubic>(a, points, out, count) : Points<Trilinear>(a, points, out, count);
  return true;
}

#endif

} // namespace HWY_NAMESPACE
} // namespace bccsplat::bench
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat::bench {
HWY_EXPORT(MarchBlock);
HWY_EXPORT(MarchPoints);

namespace {

MarchPacketArgs grid_args(const MarchGrid& grid) {
  MarchPacketArgs a;
  a.cubic = grid.interpolation == Interpolation::tricubic, a.value = grid.value.data();
  a.origin = static_cast<int>(grid.origin), a.row = static_cast<int>(grid.row),
  a.plane = static_cast<int>(grid.plane);
  a.cells = grid.cells;
  return a;
}

} // namespace

bool march_values(const MarchGrid& grid, std::span<const MarchPoint> points,
                  std::span<MarchFieldValue> values) {
  return HWY_DYNAMIC_DISPATCH(MarchPoints)(grid_args(grid), points.data(), values.data(), points.size());
}

void ray_march(const MarchScene& scene, const MarchOptions& options, const Context& context, Image& image) {
  const MarchGrid& grid = *scene.grid;
  const Slice domain = grid_domain(grid);
  const SheetView view =
      make_view(domain, resolve_camera(scene.camera), image.width, image.height, options.step);
  const ClassTable table = march_table(scene, options);
  MarchPacketArgs a = grid_args(grid);
  const auto narrow = [](const Vec3& v) {
    return std::array<float, 3>{static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
  };
  a.distance = options.skip ? scene.distance->data() : nullptr;
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
  a.least_cosine = least_cosine(scene.lights.shininess);
  for (const Light& l : scene.lights.lights) {
    const bool headlight = dot(l.direction, l.direction) == 0;
    a.lights[a.light_count++] = {
        headlight, headlight ? std::array<float, 3>{} : narrow(normalized(l.direction)), narrow(l.color)};
  }
  const int nx = (image.width + march_block - 1) / march_block,
            ny = (image.height + march_block - 1) / march_block;
  std::atomic<bool> vectors{true};
  context.tasks.parallel_for(static_cast<uint64_t>(nx) * ny, [&](uint64_t n) {
    const int x = static_cast<int>(n % static_cast<uint64_t>(nx)),
              y = static_cast<int>(n / static_cast<uint64_t>(nx));
    if (!HWY_DYNAMIC_DISPATCH(MarchBlock)(a, x * march_block, y * march_block)) vectors = false;
  });
  if (!vectors) ray_march_reference(scene, options, image);
}

} // namespace bccsplat::bench
#endif
