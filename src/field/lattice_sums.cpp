// SPDX-License-Identifier: Apache-2.0
// Sums over the sites themselves, and tables of them over an eighth of a cell.
#include "field/lattice_sums.h"

#include <hwy/cache_control.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
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

LatticeSums::Place LatticeSums::place_of(const Vec3& p) const {
  const double per_cell = 0.5 / half_;
  Place place;
  for (size_t a = 3; a-- > 0;) {
    const double t = p[a] * per_cell;
    auto whole = static_cast<double>(static_cast<int64_t>(t));
    if (whole > t) whole -= 1;
    const double folded = t - whole; // of a cell
    place.sign[a] = folded > 0.5 ? -1 : 1;
    const double at = 2 * std::min(folded, 1 - folded) * static_cast<double>(cells_);
    const size_t entry = std::min(static_cast<size_t>(at), cells_ - 1);
    place.part[a] = static_cast<float>(at - static_cast<double>(entry));
    place.entry = place.entry * (cells_ + 1) + entry;
  }
  return place;
}

LatticeSum LatticeSums::sum_at(const Place& place) const {
  // Trilinear, the four numbers of an entry side by side.
  using Entry = std::array<float, 4>;
  const auto mix = [](const Entry& from, const Entry& to, float w) {
    Entry out;
    for (size_t q = 0; q < 4; ++q) out[q] = from[q] + w * (to[q] - from[q]);
    return out;
  };
  const size_t row = cells_ + 1;
  const auto along_x = [&](size_t n) { return mix(table_[n], table_[n + 1], place.part[0]); };
  const auto along_y = [&](size_t n) { return mix(along_x(n), along_x(n + row), place.part[1]); };
  const Entry sum = mix(along_y(place.entry), along_y(place.entry + row * row), place.part[2]);
  const auto wide = [&](size_t q) { return static_cast<double>(sum[q]); };
  return {wide(3), {place.sign[0] * wide(0), place.sign[1] * wide(1), place.sign[2] * wide(2)}};
}

LatticeSum LatticeSums::at(const Vec3& p) const { return sum_at(place_of(p)); }

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
  for (size_t a = 0; a < 3; ++a) gradient[a] = sign[a] * table_[index][a];
  return gradient;
}

namespace {

Vec3 over_sum(const LatticeSum& sum, double value, const Vec3& gradient) {
  const double over = 1 / sum.value;
  return over * (gradient - (value * over) * sum.gradient);
}

} // namespace

Vec3 LatticeSums::without_ripple(const Vec3& p, double value, const Vec3& gradient) const {
  return over_sum(at(p), value, gradient);
}

// The table lies beyond the fast caches: entries are asked for well before they are used.
void LatticeSums::take_ripple_off(std::span<const Vec3> p, std::span<const double> values,
                                  std::span<Vec3> gradients) const {
  constexpr size_t ahead = 32;
  const size_t row = cells_ + 1;
  std::array<Place, ahead> place;
  for (size_t from = 0; from < p.size(); from += ahead) {
    const size_t count = std::min(ahead, p.size() - from);
    for (size_t n = 0; n < count; ++n) {
      place[n] = place_of(p[from + n]);
      for (const size_t line : {size_t{0}, row, row * row, row * row + row})
        for (const size_t x : {size_t{0}, size_t{1}}) hwy::Prefetch(&table_[place[n].entry + line + x]);
    }
    for (size_t n = 0; n < count; ++n)
      gradients[from + n] = over_sum(sum_at(place[n]), values[from + n], gradients[from + n]);
  }
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
