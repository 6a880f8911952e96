#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "slice/footprint.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include <cmath>
#include <numbers>

#include "slice/footprint.h"

#ifndef BCCSPLAT_FOOTPRINT_PATCH
#define BCCSPLAT_FOOTPRINT_PATCH
namespace bccsplat {

// No kernel reaches further than 2 sqrt2 T, two pitches: at most 4 sites of a coset per axis lie strictly
// within.
inline constexpr int patch_edge = 4;
inline constexpr int patch_sites = patch_edge * patch_edge * patch_edge;

// The sites of one coset around a point: first index per axis, distances, weights.
struct Patch {
  Int3 first{};
  alignas(64) std::array<float, patch_sites> weight;
  alignas(64) std::array<std::array<float, patch_sites>, 3> slope; // d weight / d point
};

// Where the 16 rows of 4 sites along x (z*4 + y) of a patch lie: the same in every layer of the coset.
struct PatchPlace {
  // One brick holds them all (row r at first_offset + row_offset(r)), or each row lies in one brick, or sites
  // are single.
  enum class Kind : uint8_t { one_brick, rows, sites } kind = Kind::one_brick;
  size_t slot = 0;
  int offset = 0;
  std::array<size_t, patch_edge * patch_edge> row_slot;
  std::array<int, patch_edge * patch_edge> row_offset;
  std::array<size_t, patch_sites> site_slot;
  std::array<int, patch_sites> site_offset;
};
PatchPlace place_patch(const BrickLayer& layer, const Int3& first);

// The rows in one layer: pointers into bricks, or into `copy`.
struct PatchRows {
  std::array<const float*, patch_edge * patch_edge> row;
  alignas(16) std::array<float, patch_sites> copy;
};
// False when nothing is stored there.
bool find_rows(const BrickLayer& layer, const PatchPlace& place, PatchRows& rows);

} // namespace bccsplat
#endif

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Weights of the 4^3 sites around p, and their slopes when asked for.
void WeighPatch(const RadialKernel& phi, const Vec4& p, int coset, bool slopes, Patch& patch) {
  constexpr double pitch = std::numbers::sqrt2;
  alignas(64) float delta[3][patch_edge];
  for (size_t a = 0; a < 3; ++a) {
    const double base = std::floor((p[a] - phi.radius) / pitch - 0.5 * coset);
    patch.first[a] = static_cast<int32_t>(base) + 1;
    for (int i = 0; i < patch_edge; ++i)
      delta[a][i] = static_cast<float>(p[a] - pitch * (base + 1 + i + 0.5 * coset));
  }
  const float scale = static_cast<float>(1 / (phi.radius * phi.radius));
  // One plane of the patch at a time, (y, x) in the lanes.
  alignas(64) float dx[16], dy[16], u_xy[16];
  for (int i = 0; i < 16; ++i) {
    dx[i] = delta[0][i & 3], dy[i] = delta[1][i >> 2];
    u_xy[i] = 1 - scale * (dx[i] * dx[i] + dy[i] * dy[i]);
  }
  const hn::CappedTag<float, 16> d;
  const auto zero = hn::Zero(d);
  for (size_t z = 0; z < patch_edge; ++z) {
    const auto u_z = hn::Set(d, -scale * delta[2][z] * delta[2][z]);
    for (size_t i = 0; i < 16; i += hn::Lanes(d)) {
      const auto u = hn::Add(hn::Load(d, u_xy + i), u_z);
      const auto inside = hn::Gt(u, zero);
      auto value = hn::Set(d, static_cast<float>(phi.a[static_cast<size_t>(phi.terms) - 1]));
      auto slope = zero;
      for (int j = phi.terms - 2; j >= 0; --j) {
        slope = hn::MulAdd(slope, u, value);
        value = hn::MulAdd(value, u, hn::Set(d, static_cast<float>(phi.a[static_cast<size_t>(j)])));
      }
      hn::Store(hn::IfThenElseZero(inside, value), d, patch.weight.data() + 16 * z + i);
      if (!slopes) continue;
      // d phi / d p = phi'(u) * du/dp, du/dp = -2 (p - site) / R^2
      const auto s = hn::IfThenElseZero(inside, hn::Mul(slope, hn::Set(d, -2 * scale)));
      hn::Store(hn::Mul(s, hn::Load(d, dx + i)), d, patch.slope[0].data() + 16 * z + i);
      hn::Store(hn::Mul(s, hn::Load(d, dy + i)), d, patch.slope[1].data() + 16 * z + i);
      hn::Store(hn::Mul(s, hn::Set(d, delta[2][z])), d, patch.slope[2].data() + 16 * z + i);
    }
  }
}

// Adds weight * (sum over the patch of rows times each of the first `count` (1 or 4) weight sets) to `sums`,
// lane by lane: sums holds 4 floats per set.
void DotRows(const PatchRows& rows, const Patch& patch, size_t count, float weight, float* sums) {
  const hn::CappedTag<float, patch_edge> d;
  const auto w = hn::Set(d, weight);
  for (size_t x = 0; x < patch_edge; x += hn::Lanes(d)) {
    if (count == 1) {
      auto s0 = hn::Zero(d), s1 = hn::Zero(d); // two chains of additions
      for (size_t r = 0; r < 16; r += 2) {
        s0 = hn::MulAdd(hn::LoadU(d, rows.row[r] + x), hn::Load(d, patch.weight.data() + patch_edge * r + x),
                        s0);
        s1 = hn::MulAdd(hn::LoadU(d, rows.row[r + 1] + x),
                        hn::Load(d, patch.weight.data() + patch_edge * r + 4 + x), s1);
      }
      hn::Store(hn::MulAdd(w, hn::Add(s0, s1), hn::Load(d, sums + x)), d, sums + x);
      continue;
    }
    auto s0 = hn::Zero(d), s1 = hn::Zero(d), s2 = hn::Zero(d), s3 = hn::Zero(d);
    for (size_t r = 0; r < 16; ++r) {
      const auto c = hn::LoadU(d, rows.row[r] + x);
      const size_t i = patch_edge * r + x;
      s0 = hn::MulAdd(c, hn::Load(d, patch.weight.data() + i), s0);
      s1 = hn::MulAdd(c, hn::Load(d, patch.slope[0].data() + i), s1);
      s2 = hn::MulAdd(c, hn::Load(d, patch.slope[1].data() + i), s2);
      s3 = hn::MulAdd(c, hn::Load(d, patch.slope[2].data() + i), s3);
    }
    hn::Store(hn::MulAdd(w, s0, hn::Load(d, sums + x)), d, sums + x);
    hn::Store(hn::MulAdd(w, s1, hn::Load(d, sums + 4 + x)), d, sums + 4 + x);
    hn::Store(hn::MulAdd(w, s2, hn::Load(d, sums + 8 + x)), d, sums + 8 + x);
    hn::Store(hn::MulAdd(w, s3, hn::Load(d, sums + 12 + x)), d, sums + 12 + x);
  }
}

void SumFootprints(const FieldLayers& field, std::span<const Vec4> points, float* values,
                   std::array<float, 4>* gradients) {
  const TemporalKernel& beta = field.kernel->time;
  const bool normalised = field.kernel->normalised;
  const bool slopes = gradients != nullptr;
  for (size_t n = 0; n < points.size(); ++n) {
    const Vec4& p = points[n];
    std::array<Patch, 2> patch;
    std::array<PatchPlace, 2> place;
    std::array<bool, 2> weighed{};
    // Per coset, 4 lanes each: value and spatial slopes weighted in time, value weighted by the temporal
    // slope; and the sums of both temporal weights, which a normalised kernel divides by.
    alignas(16) std::array<std::array<float, 20>, 2> lanes{};
    std::array<double, 2> beta_sum{}, beta_slope_sum{};
    for (const FieldLayer& l : field.layers) {
      const auto c = static_cast<size_t>(l.layer->coset());
      const double w = field.timeless ? 1 : beta.value(p[3] - l.time);
      const double dw = field.timeless || !slopes ? 0 : beta.slope(p[3] - l.time);
      if (w == 0 && dw == 0) continue;
      beta_sum[c] += w, beta_slope_sum[c] += dw;
      if (!weighed[c]) {
        WeighPatch(field.kernel->space, p, static_cast<int>(c), slopes, patch[c]);
        place[c] = place_patch(*l.layer, patch[c].first);
        weighed[c] = true;
      }
      PatchRows rows;
      if (!find_rows(*l.layer, place[c], rows)) continue;
      DotRows(rows, patch[c], slopes ? 4 : 1, static_cast<float>(w), lanes[c].data());
      if (dw != 0) DotRows(rows, patch[c], 1, static_cast<float>(dw), lanes[c].data() + 16);
    }
    std::array<std::array<float, 5>, 2> sum{};
    for (size_t c = 0; c < 2; ++c)
      for (size_t i = 0; i < (slopes ? 5u : 1u); ++i)
        sum[c][i] = (lanes[c][4 * i] + lanes[c][4 * i + 1]) + (lanes[c][4 * i + 2] + lanes[c][4 * i + 3]);
    if (normalised && !field.timeless)
      for (size_t c = 0; c < 2; ++c)
        if (beta_sum[c] > 0) {
          const auto inverse = static_cast<float>(1 / beta_sum[c]);
          for (float& v : sum[c]) v *= inverse;
          sum[c][4] -= sum[c][0] * static_cast<float>(beta_slope_sum[c]) * inverse;
        }
    float value = sum[0][0] + sum[1][0];
    std::array<float, 4> gradient{};
    for (size_t i = 0; i < 4; ++i) gradient[i] = sum[0][i + 1] + sum[1][i + 1];
    if (normalised) {
      const double total = lattice_sum(*field.kernel, p[0], p[1], p[2]);
      for (size_t a = 0; a < 3 && slopes; ++a) {
        constexpr double h = 1e-4;
        Vec4 low = p, high = p;
        low[a] -= h, high[a] += h;
        const double slope = (lattice_sum(*field.kernel, high[0], high[1], high[2]) -
                              lattice_sum(*field.kernel, low[0], low[1], low[2])) /
                             (2 * h);
        gradient[a] -= static_cast<float>(value / total * slope);
      }
      value = static_cast<float>(value / total);
      for (float& g : gradient) g = static_cast<float>(g / total);
    }
    values[n] = value;
    if (slopes) gradients[n] = gradient;
  }
}

} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {
HWY_EXPORT(SumFootprints);

namespace {
alignas(16) constexpr float zero_row[patch_edge] = {};
} // namespace

PatchPlace place_patch(const BrickLayer& layer, const Int3& first) {
  PatchPlace p;
  bool inside = true;
  for (size_t a = 0; a < 3; ++a) inside = inside && first[a] >= 0 && first[a] + patch_edge <= layer.dims()[a];
  constexpr int last_start = brick_edge - patch_edge;
  const Int3 at{first[0] & 15, first[1] & 15, first[2] & 15};
  if (inside && at[0] <= last_start && at[1] <= last_start && at[2] <= last_start) {
    p.slot = layer.slot(first[0] >> 4, first[1] >> 4, first[2] >> 4);
    p.offset = (at[2] * brick_edge + at[1]) * brick_edge + at[0];
    return p;
  }
  // Bricks or mirrors meet inside the patch: each index's brick and place along its axis.
  int brick[3][patch_edge], place[3][patch_edge];
  for (size_t a = 0; a < 3; ++a)
    for (int i = 0; i < patch_edge; ++i) {
      const int index = inside ? first[a] + i : layer.lattice().mirror(a, layer.coset(), first[a] + i);
      brick[a][i] = index / brick_edge, place[a][i] = index % brick_edge;
    }
  const bool rows = place[0][1] == place[0][0] + 1 && place[0][3] == place[0][0] + 3;
  p.kind = rows ? PatchPlace::Kind::rows : PatchPlace::Kind::sites;
  for (int z = 0; z < patch_edge; ++z)
    for (int y = 0; y < patch_edge; ++y) {
      const auto r = static_cast<size_t>(z * patch_edge + y);
      const int offset = (place[2][z] * brick_edge + place[1][y]) * brick_edge;
      if (rows) {
        p.row_slot[r] = layer.slot(brick[0][0], brick[1][y], brick[2][z]);
        p.row_offset[r] = offset + place[0][0];
        continue;
      }
      for (int x = 0; x < patch_edge; ++x) {
        p.site_slot[r * patch_edge + static_cast<size_t>(x)] =
            layer.slot(brick[0][x], brick[1][y], brick[2][z]);
        p.site_offset[r * patch_edge + static_cast<size_t>(x)] = offset + place[0][x];
      }
    }
  return p;
}

bool find_rows(const BrickLayer& layer, const PatchPlace& p, PatchRows& rows) {
  if (p.kind == PatchPlace::Kind::one_brick) {
    const Brick* b = layer.brick(p.slot);
    if (!b) return false;
    const float* corner = b->value.data() + p.offset;
    for (int r = 0; r < 16; ++r)
      rows.row[static_cast<size_t>(r)] = corner + ((r >> 2) * brick_edge + (r & 3)) * brick_edge;
    return true;
  }
  bool any = false;
  if (p.kind == PatchPlace::Kind::rows) {
    for (size_t r = 0; r < 16; ++r) {
      const Brick* b = layer.brick(p.row_slot[r]);
      rows.row[r] = b ? b->value.data() + p.row_offset[r] : zero_row;
      any = any || b;
    }
    return any;
  }
  for (size_t i = 0; i < patch_sites; ++i) {
    const Brick* b = layer.brick(p.site_slot[i]);
    rows.copy[i] = b ? b->value[static_cast<size_t>(p.site_offset[i])] : 0.0f;
    any = any || b;
  }
  for (size_t r = 0; r < 16; ++r) rows.row[r] = rows.copy.data() + r * patch_edge;
  return any;
}

void sum_footprints(const FieldLayers& field, std::span<const Vec4> points, float* values,
                    std::array<float, 4>* gradients) {
  HWY_DYNAMIC_DISPATCH(SumFootprints)(field, points, values, gradients);
}

} // namespace bccsplat
#endif
