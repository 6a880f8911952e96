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

// Rows of 4 sites along x, (z*4 + y), of a patch in one layer: pointers into bricks, or into `copy`.
struct PatchRows {
  std::array<const float*, patch_edge * patch_edge> row;
  std::array<float, patch_sites> copy;
};

// False when nothing is stored around the point.
bool find_rows(const BrickLayer& layer, const Int3& first, PatchRows& rows);

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

// Sum over the patch of rows times each of `count` (1 or 4) weight sets.
void DotRows(const PatchRows& rows, const float* const* weights, size_t count, float* sums) {
  const hn::CappedTag<float, patch_edge> d;
  const auto at = [&](size_t set, size_t r, size_t x) {
    return hn::Load(d, weights[set] + patch_edge * r + x);
  };
  auto s0 = hn::Zero(d), s1 = hn::Zero(d), s2 = hn::Zero(d), s3 = hn::Zero(d);
  for (size_t x = 0; x < patch_edge; x += hn::Lanes(d)) {
    if (count == 1) {
      for (size_t r = 0; r < 16; r += 2) { // two chains of additions
        s0 = hn::MulAdd(hn::LoadU(d, rows.row[r] + x), at(0, r, x), s0);
        s1 = hn::MulAdd(hn::LoadU(d, rows.row[r + 1] + x), at(0, r + 1, x), s1);
      }
      continue;
    }
    for (size_t r = 0; r < 16; ++r) {
      const auto c = hn::LoadU(d, rows.row[r] + x);
      s0 = hn::MulAdd(c, at(0, r, x), s0);
      s1 = hn::MulAdd(c, at(1, r, x), s1);
      s2 = hn::MulAdd(c, at(2, r, x), s2);
      s3 = hn::MulAdd(c, at(3, r, x), s3);
    }
  }
  if (count == 1) {
    sums[0] = hn::GetLane(hn::SumOfLanes(d, hn::Add(s0, s1)));
    return;
  }
  sums[0] = hn::GetLane(hn::SumOfLanes(d, s0));
  sums[1] = hn::GetLane(hn::SumOfLanes(d, s1));
  sums[2] = hn::GetLane(hn::SumOfLanes(d, s2));
  sums[3] = hn::GetLane(hn::SumOfLanes(d, s3));
}

void SumFootprints(const FieldLayers& field, std::span<const Vec4> points, float* values,
                   std::array<float, 4>* gradients) {
  const TemporalKernel& beta = field.kernel->time;
  const bool normalised = field.kernel->normalised;
  const bool slopes = gradients != nullptr;
  for (size_t n = 0; n < points.size(); ++n) {
    const Vec4& p = points[n];
    std::array<Patch, 2> patch;
    std::array<bool, 2> weighed{};
    // Per coset: value and spatial slopes weighted in time, value weighted by the temporal slope; and the
    // sums of both temporal weights, which a normalised kernel divides by.
    std::array<std::array<float, 5>, 2> sum{};
    std::array<double, 2> beta_sum{}, beta_slope_sum{};
    for (const FieldLayer& l : field.layers) {
      const auto c = static_cast<size_t>(l.layer->coset());
      const double w = field.timeless ? 1 : beta.value(p[3] - l.time);
      const double dw = field.timeless || !slopes ? 0 : beta.slope(p[3] - l.time);
      if (w == 0 && dw == 0) continue;
      beta_sum[c] += w, beta_slope_sum[c] += dw;
      if (!weighed[c]) {
        WeighPatch(field.kernel->space, p, static_cast<int>(c), slopes, patch[c]);
        weighed[c] = true;
      }
      PatchRows rows;
      if (!find_rows(*l.layer, patch[c].first, rows)) continue;
      const float* const weights[4] = {patch[c].weight.data(), patch[c].slope[0].data(),
                                       patch[c].slope[1].data(), patch[c].slope[2].data()};
      float dots[4];
      DotRows(rows, weights, slopes ? 4 : 1, dots);
      for (size_t i = 0; i < (slopes ? 4u : 1u); ++i) sum[c][i] += static_cast<float>(w) * dots[i];
      sum[c][4] += static_cast<float>(dw) * dots[0];
    }
    if (normalised && !field.timeless)
      for (size_t c = 0; c < 2; ++c)
        if (beta_sum[c] > 0) {
          const auto inverse = static_cast<float>(1 / beta_sum[c]);
          for (float& s : sum[c]) s *= inverse;
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

bool find_rows(const BrickLayer& layer, const Int3& first, PatchRows& rows) {
  bool inside = true;
  for (size_t a = 0; a < 3; ++a) inside = inside && first[a] >= 0 && first[a] + patch_edge <= layer.dims()[a];
  const Int3 low{first[0] >> 4, first[1] >> 4, first[2] >> 4};
  const Int3 at{first[0] & 15, first[1] & 15, first[2] & 15};
  constexpr int last_start = brick_edge - patch_edge;
  if (inside && at[0] <= last_start && at[1] <= last_start && at[2] <= last_start) {
    const Brick* b = layer.brick(low[0], low[1], low[2]);
    if (!b) return false;
    const float* corner = b->value.data() + (at[2] * brick_edge + at[1]) * brick_edge + at[0];
    for (int r = 0; r < 16; ++r)
      rows.row[static_cast<size_t>(r)] = corner + ((r >> 2) * brick_edge + (r & 3)) * brick_edge;
    return true;
  }
  // Bricks or mirrors meet inside the patch: find each index's brick and place, then rows whole or site by
  // site.
  int brick[3][patch_edge], place[3][patch_edge];
  for (size_t a = 0; a < 3; ++a)
    for (int i = 0; i < patch_edge; ++i) {
      const int index = inside ? first[a] + i : layer.lattice().mirror(a, layer.coset(), first[a] + i);
      brick[a][i] = index / brick_edge, place[a][i] = index % brick_edge;
    }
  const bool whole = place[0][3] == place[0][0] + 3 && place[0][1] == place[0][0] + 1;
  bool any = false;
  for (int z = 0; z < patch_edge; ++z)
    for (int y = 0; y < patch_edge; ++y) {
      const auto r = static_cast<size_t>(z * patch_edge + y);
      const int offset = (place[2][z] * brick_edge + place[1][y]) * brick_edge;
      if (whole) {
        const Brick* b = layer.brick(brick[0][0], brick[1][y], brick[2][z]);
        rows.row[r] = b ? b->value.data() + offset + place[0][0] : zero_row;
        any = any || b;
        continue;
      }
      const Brick* b = nullptr;
      for (int x = 0; x < patch_edge; ++x) {
        if (x == 0 || brick[0][x] != brick[0][x - 1]) b = layer.brick(brick[0][x], brick[1][y], brick[2][z]);
        any = any || b;
        rows.copy[r * patch_edge + static_cast<size_t>(x)] =
            b ? b->value[static_cast<size_t>(offset + place[0][x])] : 0.0f;
      }
      rows.row[r] = rows.copy.data() + r * patch_edge;
    }
  return any;
}

void sum_footprints(const FieldLayers& field, std::span<const Vec4> points, float* values,
                    std::array<float, 4>* gradients) {
  HWY_DYNAMIC_DISPATCH(SumFootprints)(field, points, values, gradients);
}

} // namespace bccsplat
#endif
