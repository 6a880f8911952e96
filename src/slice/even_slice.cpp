// SPDX-License-Identifier: Apache-2.0
// Builds the lattice of the even slice, evaluates the slice at its sites, and filters what it finds there to
// coefficients of the same kernel.
#include "slice/even_slice.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "base/error.h"
#include "field/coefficients/coefficients.h"
#include "points/sample_source.h"
#include "slice/largest_magnitude.h"
#include "slice/time_slice.h"

namespace bccsplat {
namespace {

// Planes beyond each end of an uneven axis: mirrors right at the domain would bend the field.
constexpr int planes_beyond = 2;
// Planes for each pair of the closest samples, in those of the slice: what its kernel loses where the field
// is as rough as they can hold stays below that of its own samples (tests/unit/slice/even_slice_test.cpp).
constexpr double planes_per_sample = 1.25;
constexpr double plane_rounding = 1e-9;
// Sampling is about this part of the work, for reports of progress; filtering is the rest.
constexpr double evenly_sampled = 0.8;
// Coefficients below this part of the largest are dropped: they are less than what a float holds of it.
constexpr float dropped_of_even = 0x1p-24f;

// An axis of slice space.
struct SliceAxis {
  size_t axis = 0;           // of index space
  bool uneven = false;       // along which it runs
  double begin = 0, end = 0; // of the domain, even positions
};

// Returns which axes of index space those of slice space are.
std::array<SliceAxis, 3> slice_axes(const Slice& slice, const UnevenAxes& axes) {
  std::array<SliceAxis, 3> out;
  for (size_t k = 0; k < 3; ++k) {
    const Vec4& b = slice.basis[k];
    const auto along = std::find_if(b.begin(), b.end(), [](double v) { return v == 1; });
    const auto others = std::count_if(b.begin(), b.end(), [](double v) { return v != 0; });
    if (along == b.end() || others != 1)
      fail(Code::unsupported, "slice: a volume of uneven axes is resampled along its axes only");
    SliceAxis& a = out[k];
    a.axis = static_cast<size_t>(along - b.begin());
    a.uneven = a.axis < 3 && axes.uneven(a.axis);
    const double unit = slice.lattice_to_slice.linear[k][k], offset = slice.lattice_to_slice.offset[k];
    a.begin = offset + unit * slice.domain_begin[k], a.end = offset + unit * slice.domain_end[k];
    if (a.uneven) a.begin = axes.even_of(a.axis, a.begin), a.end = axes.even_of(a.axis, a.end);
  }
  return out;
}

// Makes the lattice of one axis, and its place in slice space.
void lay_out_axis(const Slice& from, const SliceAxis& axis, size_t k, const UnevenAxes& axes, double most,
                  Lattice4& lattice, Slice& to) {
  lattice.space.last[k] = from.lattice.last[k];
  if (axis.uneven) {
    const double unit = from.lattice_to_slice.linear[k][k], plane = from.lattice.plane_distance();
    const double wanted = wanted_refinement(axes, axis.axis), refined = std::min(wanted, most);
    to.lacking = std::max(to.lacking, wanted / refined);
    const double size = axis.end - axis.begin, distance = unit * plane / refined;
    const int32_t inside = std::max(1, static_cast<int32_t>(std::ceil(size / distance - plane_rounding)));
    lattice.space.last[k] = inside + 2 * planes_beyond;
    const double step = (size > 0 ? size / inside : distance) / plane;
    to.lattice_to_slice.linear[k] = {};
    to.lattice_to_slice.linear[k][k] = step;
    to.domain_begin[k] = planes_beyond * plane;
    to.domain_end[k] = to.domain_begin[k] + size / step;
    to.lattice_to_slice.offset[k] = axis.begin - step * to.domain_begin[k];
  }
  lattice.dims[k] = static_cast<uint32_t>(lattice.space.last[k]) + 1; // only 1 or more matters here
}

// Returns how many sites a slice may have, that pictures of it find room as well.
double most_sites(const MemoryBudget& memory) {
  constexpr double bytes_per_site = 64, sites = 1 << 26;
  return std::min(sites, static_cast<double>(memory.limit()) / 2 / bytes_per_site);
}

// Makes a lattice that is as fine as is wanted, or as `sites` allow, and its place in slice space.
Lattice4 lay_out(const Slice& from, const std::array<SliceAxis, 3>& along, const UnevenAxes& axes,
                 double sites, Slice& to) {
  Lattice4 lattice;
  lattice.kind = from.lattice.bcc ? LatticeKind::bcc : LatticeKind::cc;
  lattice.time_step = 0, lattice.last_layer = from.lattice.cosets() - 1;
  for (double most = most_refined;; most /= 2) {
    to = from;
    lattice.space = from.lattice;
    for (size_t k = 0; k < 3; ++k) lay_out_axis(from, along[k], k, axes, most, lattice, to);
    to.lattice = lattice.space;
    if (static_cast<double>(to.sites()) <= sites || most <= 1) return lattice;
  }
}

// Where the planes of one coset of the even slice stand on the lattice of the slice. An index of an uneven
// axis is looked for bit by bit, so that it is found once for each plane, and not for each site of it.
class EvenPlanes {
 public:
  EvenPlanes(const Slice& from, const Slice& to, int coset, const std::array<SliceAxis, 3>& along,
             const UnevenAxes& axes) {
    const Int3 n = to.lattice.dims(coset);
    for (size_t k = 0; k < 3; ++k)
      for (int i = 0; i < n[k]; ++i) {
        const double p = to.site(coset, {i, i, i})[k];
        auto& place = places_[k].emplace_back();
        if (!(p >= to.domain_begin[k] - looked_beyond && p <= to.domain_end[k] + looked_beyond)) continue;
        const double even = to.lattice_to_slice.linear[k][k] * p + to.lattice_to_slice.offset[k];
        place = along[k].uneven ? (axes.index_of(along[k].axis, even) - from.lattice_to_slice.offset[k]) /
                                      from.lattice_to_slice.linear[k][k]
                                : p;
      }
  }

  // Returns where a site stands; nothing where it is far from the domain.
  [[nodiscard]] std::optional<Vec3> at(const Int3& i) const {
    Vec3 q{};
    for (size_t k = 0; k < 3; ++k) {
      const std::optional<double>& place = places_[k][static_cast<size_t>(i[k])];
      if (!place) return std::nullopt;
      q[k] = *place;
    }
    return q;
  }

 private:
  std::array<std::vector<std::optional<double>>, 3> places_;
};

// Returns the slice as it goes on beyond its domain, without its mask: what that hides is filled smoothly.
Slice bare_field(const Slice& slice) {
  Slice field = slice;
  field.mask = nullptr;
  if (slice.holes_by_mask) field.has_holes = false;
  constexpr double anywhere = 1e9;
  field.domain_begin = {-anywhere, -anywhere, -anywhere}, field.domain_end = {anywhere, anywhere, anywhere};
  return field;
}

// Returns the samples of one brick; null where there is nothing.
std::shared_ptr<Brick> sample_brick(const Slice& field, const EvenPlanes& planes, const BrickLayer& layer,
                                    size_t slot) {
  const Int3 at = layer.slot_position(slot), n = layer.dims();
  std::vector<Vec3> points;
  std::vector<int> sites;
  for (int s = 0; s < brick_sites; ++s) {
    const Int3 i{at[0] * brick_edge + s % brick_edge, at[1] * brick_edge + s / brick_edge % brick_edge,
                 at[2] * brick_edge + s / brick_rows};
    if (i[0] >= n[0] || i[1] >= n[1] || i[2] >= n[2]) continue;
    const std::optional<Vec3> place = planes.at(i);
    if (!place) continue;
    points.push_back(*place), sites.push_back(s);
  }
  if (points.empty()) return nullptr;
  std::vector<float> values(points.size());
  evaluate(field, points, values, {});
  auto brick = std::make_shared<Brick>();
  for (size_t i = 0; i < sites.size(); ++i) {
    const auto site = static_cast<size_t>(sites[i]);
    if (!std::isnan(values[i])) {
      brick->value[site] = values[i] - field.base;
      continue;
    }
    if (!brick->hole) brick->hole = std::make_unique<BrickMask>();
    auto& row = (*brick->hole)[site / brick_edge];
    row = static_cast<uint16_t>(row | 1u << site % brick_edge);
  }
  return brick->keep_above(0) > 0 || brick->hole ? brick : nullptr;
}

} // namespace

double wanted_refinement(const UnevenAxes& axes, size_t axis) {
  return axes.uneven(axis) ? planes_per_sample / axes.closest(axis) : 1;
}

Slice even_slice(const Slice& slice, const std::shared_ptr<const UnevenAxes>& axes, const Context& context) {
  if (slice.empty()) return slice;
  const std::array<SliceAxis, 3> along = slice_axes(slice, *axes);
  Slice to;
  const Lattice4 lattice = lay_out(slice, along, *axes, most_sites(context.memory), to);
  const Slice field = bare_field(slice);
  std::vector<BrickLayer> layers;
  float most = 0;
  for (int c = 0; c < to.lattice.cosets(); ++c) {
    BrickLayer layer(to.lattice, c);
    const EvenPlanes planes(slice, to, c, along, *axes);
    const Reservation memory(context.memory, layer.brick_slots() * sizeof(Brick), "a slice of uneven axes");
    std::vector<std::shared_ptr<Brick>> made(layer.brick_slots());
    std::atomic<uint64_t> done{0};
    const double part = evenly_sampled / to.lattice.cosets();
    Progress sampling(context.progress, c * part, (c + 1) * part);
    context.tasks.parallel_for(made.size(), [&](uint64_t slot) {
      sampling.advance(done.fetch_add(1, std::memory_order_relaxed), made.size());
      made[slot] = sample_brick(field, planes, layer, slot);
    });
    for (size_t slot = 0; slot < made.size(); ++slot) layer.set(slot, std::move(made[slot]));
    most = std::max(most, largest_magnitude(layer));
    layers.push_back(std::move(layer));
  }
  std::vector<std::vector<BrickLayer>> channels;
  channels.push_back(std::move(layers));
  const MemorySamples samples(lattice, {slice.base}, std::move(channels));
  const Coefficients coefficients(samples, 0, slice.kernel, most * dropped_of_even,
                                  std::numeric_limits<uint64_t>::max());
  Progress filtering(context.progress, evenly_sampled, 1);
  to.has_holes = false;
  for (int c = 0; c < to.lattice.cosets(); ++c) {
    to.coset[c] = *coefficients.layer(c, context.with(filtering));
    for (size_t s = 0; s < to.coset[c].brick_slots(); ++s)
      to.has_holes = to.has_holes || (to.coset[c].brick(s) && to.coset[c].brick(s)->hole);
  }
  to.bounds = coefficient_bounds(to);
  to.corrections = nullptr;
  for (size_t a = 0; a < 3; ++a) to.origin[a] = axes->even_of(a, slice.origin[a]);
  double offset = 0;
  for (size_t a = 0; a < 4; ++a) offset -= slice.hyperplane[a] * to.origin[a];
  to.hyperplane = {slice.hyperplane[0], slice.hyperplane[1], slice.hyperplane[2], slice.hyperplane[3],
                   offset};
  to.holes_by_mask = slice.mask && !to.has_holes;
  if (slice.mask)
    to.mask = std::make_shared<const SliceMask>(slice.mask->from_even(axes, to.origin)), to.has_holes = true;
  return to;
}

IndexBox index_box(const IndexBox& even, const UnevenAxes& axes) {
  IndexBox box = even;
  for (size_t a = 0; a < 3; ++a)
    box.begin[a] = axes.index_of(a, even.begin[a]), box.end[a] = axes.index_of(a, even.end[a]);
  return box;
}

} // namespace bccsplat
