// SPDX-License-Identifier: Apache-2.0
// Moments are asked layer by layer: the few coefficients around a site are read and weighed there.
#include "gpu/value_change.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <span>
#include <vector>

#include "gpu/shader.h"
#include "kernel/cc_kernel.h"
#include "shade/surface.h"

namespace bccsplat {
namespace {

using Part = MomentPlan::Part;

// What the field of a slice is a sum of: the layers of a moment, or the cosets as they are.
std::vector<Part> parts_of(const Slice& slice) {
  if (const MomentPlan* const moment = slice.coset.moment()) return moment->parts();
  std::vector<Part> parts;
  for (int c = 0; c < slice.lattice.cosets(); ++c) {
    const BrickLayer& layer = slice.coset[static_cast<size_t>(c)];
    parts.push_back(
        {c, c, 1, {}, {std::shared_ptr<const BrickLayer>(std::shared_ptr<void>(), &layer), nullptr}});
  }
  return parts;
}

class PartSites {
 public:
  explicit PartSites(const Slice& slice) : slice_(slice), parts_(parts_of(slice)) {
    for (int c = 0; c < slice.lattice.cosets(); ++c) places_[c] = BrickLayer(slice.lattice, c);
  }

  // Some hundred sites inside the slice that are not air, of all its bricks alike.
  [[nodiscard]] std::vector<Vec3> some() const;
  // The gradient at a point, per lattice unit, without corrections.
  [[nodiscard]] Vec3 gradient(const Vec3& p) const;

 private:
  struct BrickPlace {
    int coset;
    size_t slot;
  };
  [[nodiscard]] std::vector<BrickPlace> bricks() const; // that any part has
  [[nodiscard]] bool is_kept(const BrickPlace& brick, int site) const;
  [[nodiscard]] double coefficient(int coset, const Int3& at) const;

  const Slice& slice_;
  std::vector<Part> parts_;
  std::array<BrickLayer, 2> places_; // empty ones, which know where bricks stand
};

std::vector<PartSites::BrickPlace> PartSites::bricks() const {
  std::vector<BrickPlace> out;
  for (int c = 0; c < slice_.lattice.cosets(); ++c)
    for (size_t slot = 0; slot < places_[c].brick_slots(); ++slot)
      if (std::any_of(parts_.begin(), parts_.end(),
                      [&](const Part& p) { return p.coset == c && p.of.there(slot); }))
        out.push_back({c, slot});
  return out;
}

bool PartSites::is_kept(const BrickPlace& brick, int site) const {
  return std::any_of(parts_.begin(), parts_.end(), [&](const Part& p) {
    if (p.coset != brick.coset || !p.of.there(brick.slot)) return false;
    const BrickMask* const kept = p.of.kept(brick.slot);
    return !kept || ((*kept)[static_cast<size_t>(site / brick_edge)] >> (site % brick_edge) & 1);
  });
}

std::vector<Vec3> PartSites::some() const {
  constexpr size_t asked = 512;
  const bool all = slice_.base != slice_.air;
  const std::vector<BrickPlace> of = bricks();
  const size_t count = of.size() * brick_sites;
  const size_t every = count / asked | 1; // odd: they stand at all places of bricks
  std::vector<Vec3> out;
  for (size_t n = every / 2; n < count; n += every) {
    const BrickPlace& brick = of[n / brick_sites];
    const int site = static_cast<int>(n % brick_sites);
    if (!all && !is_kept(brick, site)) continue;
    const Int3 at = places_[brick.coset].slot_position(brick.slot);
    const Vec3 p = slice_.site(brick.coset, {brick_edge * at[0] + site % brick_edge,
                                             brick_edge * at[1] + site / brick_edge % brick_edge,
                                             brick_edge * at[2] + site / brick_rows});
    if (slice_.inside(p)) out.push_back(p);
  }
  return out;
}

double PartSites::coefficient(int coset, const Int3& at) const {
  const size_t slot = places_[coset].slot(at[0] / brick_edge, at[1] / brick_edge, at[2] / brick_edge);
  const int x = at[0] % brick_edge, y = at[1] % brick_edge, z = at[2] % brick_edge;
  std::array<float, brick_edge> row; // of which codes write more than is asked for
  double sum = 0;
  for (const Part& p : parts_) {
    if (p.coset != coset || !p.of.there(slot)) continue;
    const Brick* const values =
        p.of.values ? p.of.values->brick(slot) : p.of.compact->brick(slot).values.get();
    if (values)
      row[0] = values->value[static_cast<size_t>((z * brick_edge + y) * brick_edge + x)];
    else
      p.of.compact->brick(slot).codes->read({z, x, y, 1, 1}, row.data(), brick_edge);
    sum += static_cast<double>(p.weight) * row[0];
  }
  return sum;
}

Vec3 PartSites::gradient(const Vec3& p) const {
  const Lattice3& lattice = slice_.lattice;
  const RadialKernel& kernel = slice_.kernel.space;
  const double pitch = coset_pitch(lattice.bcc), radius2 = kernel.radius * kernel.radius;
  Vec3 slope{};
  double sum = 0;
  for (int c = 0; c < lattice.cosets(); ++c) {
    Int3 first, last;
    for (size_t a = 0; a < 3; ++a) {
      first[a] = static_cast<int32_t>(std::ceil((p[a] - kernel.radius) / pitch - 0.5 * c));
      last[a] = static_cast<int32_t>(std::floor((p[a] + kernel.radius) / pitch - 0.5 * c));
    }
    for (int32_t z = first[2]; z <= last[2]; ++z)
      for (int32_t y = first[1]; y <= last[1]; ++y)
        for (int32_t x = first[0]; x <= last[0]; ++x) {
          const Vec3 v = p - slice_.site(c, {x, y, z});
          const double r2 = dot(v, v);
          if (r2 >= radius2) continue;
          const double value =
              coefficient(c, {lattice.mirror(0, c, x), lattice.mirror(1, c, y), lattice.mirror(2, c, z)});
          sum += value * kernel.value(r2);
          slope = slope + (2 * value * kernel.slope(r2)) * v;
        }
  }
  if (!slice_.kernel.normalised) return slope;
  // The quotient's, with the gradient of the lattice sum by differences.
  constexpr double h = 1e-4;
  const auto at = [&](const Vec3& q) { return lattice_sum(slice_.kernel, lattice.bcc, q[0], q[1], q[2]); };
  const double n = at(p);
  for (size_t a = 0; a < 3; ++a) {
    Vec3 step{};
    step[a] = h;
    slope[a] = (slope[a] - sum / n * (at(p + step) - at(p - step)) / (2 * h)) / n;
  }
  return slope;
}

} // namespace

double change_at_sites(const Slice& slice, const Context& context) {
  constexpr size_t percentile = 95, whole = 100, at_once = 32;
  const PartSites sites(slice);
  const std::vector<Vec3> places = sites.some();
  if (places.empty()) return 0;
  std::vector<double> lengths(places.size());
  context.tasks.parallel_for((places.size() + at_once - 1) / at_once, [&](uint64_t part) {
    const auto first = static_cast<size_t>(part) * at_once, end = std::min(first + at_once, places.size());
    for (size_t n = first; n < end; ++n) {
      Vec3 gradient = sites.gradient(places[n]), per_uvw;
      if (slice.corrections) {
        (void)slice.corrections->at(slice.lattice_to_slice.point(places[n]), &per_uvw);
        gradient = gradient + slice.lattice_to_slice.transposed(per_uvw);
      }
      lengths[n] = length(gradient);
    }
  });
  const auto at = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() * percentile / whole);
  std::nth_element(lengths.begin(), at, lengths.end());
  return *at;
}

} // namespace bccsplat
