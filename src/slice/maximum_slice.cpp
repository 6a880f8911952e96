// SPDX-License-Identifier: Apache-2.0
// The largest values of instants at the sites of their lattice, filtered to the coefficients of a slice that
// interpolates them. What is missing at every instant stays missing; what a mask hides is filled meanwhile.
#include "slice/maximum_slice.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "points/sample_source.h"

namespace bccsplat {
namespace {

// Returns the sites of a brick as points, x fastest; those beyond the coset's dims are moved to its last
// site.
std::vector<Vec3> brick_points(const Slice& slice, const BrickLayer& layer, const Int3& b) {
  std::vector<Vec3> points;
  points.reserve(brick_sites);
  for (int s = 0; s < brick_sites; ++s) {
    const Int3 local{s % brick_edge, s / brick_edge % brick_edge, s / brick_rows};
    Int3 i;
    for (size_t a = 0; a < 3; ++a) i[a] = std::min(b[a] * brick_edge + local[a], layer.dims()[a] - 1);
    points.push_back(slice.site(layer.coset(), i));
  }
  return points;
}

// A brick in which every maximum is still to come.
std::shared_ptr<Brick> empty_maxima() {
  auto brick = std::make_shared<Brick>();
  std::fill(brick->value.begin(), brick->value.end(), -std::numeric_limits<float>::infinity());
  return brick;
}

} // namespace

void SiteMaxima::add(const Slice& instant, const Context& context) {
  const bool is_first = !first_;
  if (is_first) first_ = instant;
  masks_.push_back(instant.mask);
  Slice bare = instant; // what fills missing data is needed beside them, and planes outside the domain
  bare.mask = nullptr;
  bare.domain_begin = {};
  for (size_t a = 0; a < 3; ++a)
    bare.domain_end[a] = instant.lattice.plane_distance() * instant.lattice.last[a];
  for (size_t c = 0; c < static_cast<size_t>(instant.lattice.cosets()); ++c) {
    BrickLayer layer(instant.lattice, static_cast<int>(c)), fills(instant.lattice, static_cast<int>(c));
    const double part = 1.0 / instant.lattice.cosets();
    Progress share(context.progress, static_cast<double>(c) * part, static_cast<double>(c + 1) * part);
    std::atomic<uint64_t> done{0};
    context.tasks.parallel_for(layer.brick_slots(), [&](uint64_t slot) {
      context.progress.check();
      share.advance(done.fetch_add(1, std::memory_order_relaxed), layer.brick_slots());
      const auto points = brick_points(instant, layer, layer.slot_position(slot));
      std::vector<float> values(brick_sites);
      auto brick = empty_maxima(), fill = empty_maxima();
      if (!is_first) {
        brick->value = largest_[c].brick(slot)->value;
        fill->value = fills_[c].brick(slot)->value;
      }
      evaluate(bare, points, values, {});
      for (size_t s = 0; s < brick_sites; ++s) {
        if (std::isnan(values[s])) continue;
        float& to = instant.mask && instant.is_hole(points[s]) ? fill->value[s] : brick->value[s];
        to = std::max(to, values[s] - instant.base);
      }
      layer.set(slot, std::move(brick)), fills.set(slot, std::move(fill));
    });
    largest_[c] = std::move(layer);
    fills_[c] = std::move(fills);
  }
}

Slice SiteMaxima::finish(const Context& context) {
  Slice& first = *first_;
  Lattice4 lattice; // the slices' lattice as a static volume
  lattice.kind = first.lattice.bcc ? LatticeKind::bcc : LatticeKind::cc;
  lattice.space = first.lattice;
  lattice.time_step = 0;
  lattice.last_layer = first.lattice.cosets() - 1;
  std::vector<std::vector<BrickLayer>> channels(1);
  for (size_t c = 0; c < static_cast<size_t>(first.lattice.cosets()); ++c) {
    BrickLayer layer(first.lattice, static_cast<int>(c));
    for (size_t slot = 0; slot < layer.brick_slots(); ++slot) {
      const Int3 b = layer.slot_position(slot);
      auto brick = std::make_shared<Brick>();
      for (int s = 0; s < brick_sites; ++s) {
        const auto value_of = [&](const BrickLayer& of) { return of.brick(slot)->value[s]; };
        const float v = std::isfinite(value_of(largest_[c])) ? value_of(largest_[c]) : value_of(fills_[c]);
        const bool site = b[0] * brick_edge + s % brick_edge < layer.dims()[0] &&
                          b[1] * brick_edge + s / brick_edge % brick_edge < layer.dims()[1] &&
                          b[2] * brick_edge + s / brick_rows < layer.dims()[2];
        if (!site) continue;
        if (std::isfinite(v)) {
          brick->value[s] = v;
          continue;
        }
        if (!brick->hole) brick->hole = std::make_unique<BrickMask>(); // at every instant
        (*brick->hole)[s / brick_edge] |= static_cast<uint16_t>(1u << (s % brick_edge));
      }
      if (brick->keep_above(0) > 0 || brick->hole) layer.set(slot, std::move(brick));
    }
    largest_[c] = fills_[c] = BrickLayer();
    channels[0].push_back(std::move(layer));
  }
  const MemorySamples samples(lattice, {first.base}, std::move(channels));
  const Coefficients filtered(samples, 0, first.kernel, 0, std::numeric_limits<uint64_t>::max());
  Slice result = first;
  result.corrections = nullptr; // the maxima have them
  result.holes_by_mask = false; // sites are holes that are it at every instant
  if (std::find(masks_.begin(), masks_.end(), nullptr) != masks_.end())
    result.mask = nullptr;
  else
    result.mask = std::make_shared<const SliceMask>(first.mask->also(masks_));
  for (int c = 0; c < first.lattice.cosets(); ++c) result.coset[c] = *filtered.layer(c, context);
  result.bounds = coefficient_bounds(result);
  return result;
}

} // namespace bccsplat
