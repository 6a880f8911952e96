// SPDX-License-Identifier: Apache-2.0
// Sums over the sites themselves, and tables of them over an eighth of a cell.
#include "field/lattice_sums.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace bccsplat {
namespace {

double pitch_of(bool bcc) { return bcc ? std::numbers::sqrt2 : 1; }

// The sites of one coset, one of which stands at (offset, offset, offset).
void add_coset(const RadialKernel& kernel, double pitch, double offset, const Vec3& p, LatticeSum& sum) {
  const double r = kernel.radius;
  std::array<int, 3> first{}, last{};
  for (size_t a = 0; a < 3; ++a) {
    first[a] = static_cast<int>(std::ceil((p[a] - offset - r) / pitch));
    last[a] = static_cast<int>(std::floor((p[a] - offset + r) / pitch));
  }
  for (int z = first[2]; z <= last[2]; ++z)
    for (int y = first[1]; y <= last[1]; ++y)
      for (int x = first[0]; x <= last[0]; ++x) {
        const Vec3 d = p - Vec3{pitch * x + offset, pitch * y + offset, pitch * z + offset};
        const double r2 = dot(d, d);
        if (!(r2 < r * r)) continue;
        sum.value += kernel.value(r2);
        sum.gradient = sum.gradient + (2 * kernel.slope(r2)) * d;
      }
}

} // namespace

LatticeSum lattice_sum_at(const RadialKernel& kernel, bool bcc, const Vec3& p) {
  const double pitch = pitch_of(bcc);
  LatticeSum sum{0, {}};
  add_coset(kernel, pitch, 0, p, sum);
  if (bcc) add_coset(kernel, pitch, pitch / 2, p, sum);
  return sum;
}

LatticeSums::LatticeSums(const RadialKernel& kernel, bool bcc, size_t cells)
    : cells_(cells), half_(pitch_of(bcc) / 2), table_((cells + 1) * (cells + 1) * (cells + 1)) {
  // Axes are alike: those places whose coordinates rise tell the others.
  for (size_t k = 0; k <= cells; ++k)
    for (size_t j = 0; j <= k; ++j)
      for (size_t i = 0; i <= j; ++i) {
        std::array<size_t, 3> place{i, j, k}, axis{0, 1, 2};
        const double d = half_ / static_cast<double>(cells);
        const LatticeSum sum = lattice_sum_at(
            kernel, bcc,
            {d * static_cast<double>(i), d * static_cast<double>(j), d * static_cast<double>(k)});
        do {
          auto& entry =
              table_[(place[axis[2]] * (cells + 1) + place[axis[1]]) * (cells + 1) + place[axis[0]]];
          for (size_t a = 0; a < 3; ++a) entry[a] = static_cast<float>(sum.gradient[axis[a]]);
          entry[3] = static_cast<float>(sum.value);
        } while (std::next_permutation(axis.begin(), axis.end()));
      }
}

LatticeSum LatticeSums::at(const Vec3& p) const {
  std::array<size_t, 3> cell{};
  Vec3 part, sign;
  for (size_t a = 0; a < 3; ++a) {
    const double t = p[a] / (2 * half_), folded = t - std::floor(t); // of a cell
    sign[a] = folded > 0.5 ? -1 : 1;
    const double at = 2 * std::min(folded, 1 - folded) * static_cast<double>(cells_);
    cell[a] = std::min(static_cast<size_t>(at), cells_ - 1);
    part[a] = at - static_cast<double>(cell[a]);
  }
  std::array<double, 4> sum{};
  for (size_t n = 0; n < 8; ++n) {
    double weight = 1;
    size_t index = 0;
    for (size_t a = 3; a-- > 0;) {
      const size_t bit = n >> a & 1;
      weight *= bit ? part[a] : 1 - part[a];
      index = index * (cells_ + 1) + cell[a] + bit;
    }
    for (size_t q = 0; q < 4; ++q) sum[q] += weight * static_cast<double>(table_[index][q]);
  }
  return {sum[3], {sign[0] * sum[0], sign[1] * sum[1], sign[2] * sum[2]}};
}

Vec3 LatticeSums::nearest_gradient(const Vec3& p) const {
  Vec3 sign;
  size_t index = 0;
  for (size_t a = 3; a-- > 0;) {
    const double from_site = p[a] - std::nearbyint(p[a]);
    sign[a] = from_site < 0 ? -1 : 1;
    index = index * (cells_ + 1) +
            static_cast<size_t>(std::nearbyint(2 * std::fabs(from_site) * static_cast<double>(cells_)));
  }
  Vec3 gradient;
  for (size_t a = 0; a < 3; ++a) gradient[a] = sign[a] * static_cast<double>(table_[index][a]);
  return gradient;
}

Vec3 LatticeSums::without_ripple(const Vec3& p, double value, const Vec3& gradient) const {
  const LatticeSum sum = at(p);
  return (1 / sum.value) * (gradient - (value / sum.value) * sum.gradient);
}

namespace {

bool same(const RadialKernel& a, const RadialKernel& b) {
  return a.radius == b.radius && a.terms == b.terms && a.a == b.a;
}

std::shared_ptr<const LatticeSums> sums_of(const Slice& slice, const RadialKernel& kernel, size_t cells,
                                           KeptLatticeSums* kept) {
  if (slice.kernel.normalised || slice.corrections) return nullptr;
  const bool bcc = slice.lattice.bcc;
  return kept ? kept->find(kernel, bcc, cells) : std::make_shared<const LatticeSums>(kernel, bcc, cells);
}

} // namespace

std::shared_ptr<const LatticeSums> KeptLatticeSums::find(const RadialKernel& kernel, bool bcc, size_t cells) {
  const std::lock_guard lock(mutex_);
  Kept& kept = kept_[cells];
  if (!kept.sums || kept.bcc != bcc || !same(kept.kernel, kernel))
    kept = {kernel, bcc, std::make_shared<const LatticeSums>(kernel, bcc, cells)};
  return kept.sums;
}

std::shared_ptr<const LatticeSums> lattice_sums(const Slice& slice, KeptLatticeSums* kept) {
  return sums_of(slice, slice.kernel.space, LatticeSums::fine, kept);
}

std::shared_ptr<const LatticeSums> lattice_sums(const Slice& slice, const RadialKernel& drawn,
                                                KeptLatticeSums* kept) {
  return sums_of(slice, drawn, LatticeSums::coarse, kept);
}

} // namespace bccsplat
