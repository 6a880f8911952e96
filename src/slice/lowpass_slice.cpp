// SPDX-License-Identifier: Apache-2.0
// Weighs the samples of a slice around the sites of a coarser one: the finer lattice is copied to planes
// without gaps, and the sums run along its rows.
#include "slice/lowpass_slice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "base/grid.h"
#include "field/footprint/patch.h"

namespace bccsplat {
namespace {

// Returns the modified Bessel function of order 0.
double bessel(double x) {
  double sum = 1, term = 1;
  for (int n = 1; term > 1e-15 * sum; ++n) {
    term *= x * x / (4.0 * n * n);
    sum += term;
  }
  return sum;
}

// Weights by the square of the distance.
class Weights {
 public:
  static constexpr size_t steps = 4096;
  Weights() {
    for (size_t n = 0; n < table_.size(); ++n)
      table_[n] =
          static_cast<float>(lowpass_weight(lowpass_reach * std::sqrt(static_cast<double>(n) / steps)));
  }
  [[nodiscard]] float operator()(double r2) const {
    const double at = r2 * (steps / (lowpass_reach * lowpass_reach));
    const auto n = static_cast<size_t>(at);
    return n < steps
               ? table_[n] + static_cast<float>(at - static_cast<double>(n)) * (table_[n + 1] - table_[n])
               : 0.0f;
  }

 private:
  std::array<float, steps + 1> table_{};
};

// One coset of the finer slice, dense, with the way from slice space to its sites.
struct DenseCoset {
  const Slice& slice;
  int coset;
  Int3 dims;
  std::vector<float> value;

  DenseCoset(const Slice& s, int c)
      : slice(s), coset(c), dims(s.lattice.dims(c)), value(layer_to_dense(s.coset[c])) {}

  // Returns the number of a site along an axis, fractional, of a place in slice space.
  [[nodiscard]] double site(size_t axis, double u) const {
    const double unit = slice.lattice_to_slice.linear[axis][axis],
                 offset = slice.lattice_to_slice.offset[axis];
    return (u - offset) / (unit * coset_pitch(slice.lattice)) - (slice.lattice.bcc ? 0.5 * coset : 0);
  }
  // Returns the distance of its sites along an axis, slice space.
  [[nodiscard]] double pitch(size_t axis) const {
    return slice.lattice_to_slice.linear[axis][axis] * coset_pitch(slice.lattice);
  }

  // Adds its samples around `p`, and their weights.
  void add(const Vec3& p, const Vec3& unit, const Weights& weights, double& sum, double& weight) const {
    Vec3 at, step;
    Int3 first, last;
    for (size_t a = 0; a < 3; ++a) {
      at[a] = site(a, p[a]), step[a] = pitch(a) / unit[a];
      first[a] = static_cast<int32_t>(std::ceil(at[a] - lowpass_reach / step[a]));
      last[a] = static_cast<int32_t>(std::floor(at[a] + lowpass_reach / step[a]));
    }
    std::vector<int32_t> column;
    for (int32_t x = first[0]; x <= last[0]; ++x) column.push_back(slice.lattice.mirror(0, coset, x));
    for (int32_t z = first[2]; z <= last[2]; ++z)
      for (int32_t y = first[1]; y <= last[1]; ++y) {
        const double dz = (z - at[2]) * step[2], dy = (y - at[1]) * step[1], off = dz * dz + dy * dy;
        if (off > lowpass_reach * lowpass_reach) continue;
        const auto row = static_cast<size_t>(slice.lattice.mirror(2, coset, z)) * dims[1] +
                         slice.lattice.mirror(1, coset, y);
        const float* const values = value.data() + row * dims[0];
        for (int32_t x = first[0]; x <= last[0]; ++x) {
          const double dx = (x - at[0]) * step[0];
          const float w = weights(off + dx * dx);
          sum += w * values[column[x - first[0]]], weight += w;
        }
      }
  }
};

// Returns the place in the slice's domain that p, beyond its ends, is the mirror image of.
Vec3 mirrored(const Slice& slice, Vec3 p) {
  for (size_t a = 0; a < 3; ++a) {
    p[a] = std::clamp(p[a], 2 * slice.domain_begin[a] - slice.domain_end[a],
                      2 * slice.domain_end[a] - slice.domain_begin[a]);
    if (p[a] < slice.domain_begin[a]) p[a] = 2 * slice.domain_begin[a] - p[a];
    if (p[a] > slice.domain_end[a]) p[a] = 2 * slice.domain_end[a] - p[a];
  }
  return p;
}

} // namespace

double lowpass_weight(double r) {
  constexpr double cut = 0.45, beta = 6, flat = 1e-3;
  if (r >= lowpass_reach) return 0;
  const double x = 2 * std::numbers::pi * cut * r, part = r / lowpass_reach;
  const double ideal = x < flat ? 1 : 3 * (std::sin(x) - x * std::cos(x)) / (x * x * x);
  return ideal * bessel(beta * std::sqrt(1 - part * part)) / bessel(beta);
}

std::vector<BrickLayer> lowpassed_samples(const Slice& fine, const Slice& coarse, const Vec3& unit,
                                          const std::function<bool(const Vec3&)>& near,
                                          const Context& context) {
  static const Weights weights;
  const Reservation memory(context.memory, static_cast<uint64_t>(fine.sites()) * sizeof(float),
                           "slice: samples to be low-passed");
  std::vector<DenseCoset> from;
  for (int c = 0; c < fine.lattice.cosets(); ++c) from.emplace_back(fine, c);
  std::vector<BrickLayer> layers;
  for (int c = 0; c < coarse.lattice.cosets(); ++c) {
    BrickLayer layer(coarse.lattice, c);
    const Int3 n = layer.dims();
    std::vector<std::shared_ptr<Brick>> made(layer.brick_slots());
    context.tasks.parallel_for(made.size(), [&](uint64_t slot) {
      const Int3 b = layer.slot_position(slot);
      auto brick = std::make_shared<Brick>();
      for (int s = 0; s < brick_sites; ++s) {
        if (s % brick_rows == 0) context.progress.check();
        const Int3 i{b[0] * brick_edge + s % brick_edge, b[1] * brick_edge + s / brick_edge % brick_edge,
                     b[2] * brick_edge + s / brick_rows};
        if (i[0] >= n[0] || i[1] >= n[1] || i[2] >= n[2]) continue;
        const Vec3 at = coarse.site(c, i);
        if (!near(coarse.lattice_to_slice.point(at))) continue;
        const Vec3 p = coarse.lattice_to_slice.point(mirrored(coarse, at));
        double sum = 0, weight = 0;
        for (const DenseCoset& d : from) d.add(p, unit, weights, sum, weight);
        brick->value[s] = static_cast<float>(sum / weight);
        if (!fine.has_holes || !fine.is_hole(fine.lattice_to_slice.inverse().point(p))) continue;
        if (!brick->hole) brick->hole = std::make_unique<BrickMask>();
        auto& row = (*brick->hole)[s / brick_edge];
        row = static_cast<uint16_t>(row | 1u << s % brick_edge);
      }
      if (brick->keep_above(0) > 0 || brick->hole) made[slot] = std::move(brick);
    });
    for (size_t slot = 0; slot < made.size(); ++slot) layer.set(slot, std::move(made[slot]));
    layers.push_back(std::move(layer));
  }
  return layers;
}

} // namespace bccsplat
