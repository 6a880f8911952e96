// SPDX-License-Identifier: Apache-2.0
// Gathers layers into slabs within the memory budget, counts what is counted of them, and hands them out.
#include <algorithm>

#include "fit/fit_state.h"

namespace bccsplat {
namespace {

// Returns what a brick of a layer takes at most, codes that do not give back every value excepted (none do).
uint64_t most_bytes(ValueType type) {
  constexpr uint64_t beside_codes = 1400; // which sites are kept, where rows start
  return is_float(type) ? sizeof(Brick) : value_bytes(type) * brick_sites + beside_codes;
}

// Returns the number of bricks of which any tap has sites.
uint64_t bricks_of(const BrickLayer& shape, std::span<const LayerTap> taps) {
  const size_t coset = shape.coset();
  uint64_t bricks = 0;
  for (size_t slot = 0; slot < shape.brick_slots(); ++slot)
    bricks += std::any_of(taps.begin(), taps.end(),
                          [&](const LayerTap& tap) { return tap.frame->block[coset][slot] != nullptr; });
  return bricks;
}

} // namespace

void Fit::State::emit(Channel& c, int32_t layer, std::span<const LayerTap> taps, size_t nearest) {
  const int coset = lattice.coset(layer);
  const bool beyond = layer < lattice.lead || (length_known() && layer > lattice.last_layer - lattice.lead);
  const uint64_t bricks = bricks_of(BrickLayer(lattice.space, coset), taps);
  Reservation memory(context.memory, bricks * most_bytes(c.options.quantiser.type), "a slab of layers");
  const bool counted = counts_layer(layer), lasting = layer < options.lasting_layers;
  LayerMaker& maker = !counted ? c.uncounted : lasting ? c.lasting : c.maker;
  const uint64_t clamped_before = maker.clamped();
  c.slab.push_back(maker.make(lattice.space, coset, taps, nearest, beyond, context));
  memory = {};
  c.slab_memory.emplace_back(context.memory, c.slab.back().bytes(), "a slab of layers");
  if (counted) {
    (lasting ? c.report.lasting.sites_total : c.report.sites_total) += lattice.space.sites(coset);
    const int32_t first = options.part ? options.part->first_own : 0;
    const size_t slab = (layer - first) / options.slab_layers;
    c.report.clamped_slabs.resize(std::max(c.report.clamped_slabs.size(), slab + 1));
    c.report.clamped_slabs[slab] += maker.clamped() - clamped_before;
  }
  const bool last = options.periodic && layer == lattice.last_layer;
  if (last || static_cast<int32_t>(c.slab.size()) == handed_layers()) hand_out(c);
  if (last) c.slab_index = 0;
}

void Fit::State::hand_out(Channel& c) {
  if (c.slab.empty()) return;
  if (options.one_by_one) c.slab_memory.clear();
  sink(c.slab_index++, c.index, c.slab);
  c.slab.clear();
  c.slab_memory.clear();
}

} // namespace bccsplat
