// SPDX-License-Identifier: Apache-2.0
// Gathers layers into slabs within the memory budget, counts what is counted of them, and hands them out.
#include <algorithm>
#include <utility>

#include "fit/fit_state.h"

namespace bccsplat {

void Fit::State::emit(Channel& c, int32_t layer, std::span<const LayerTap> taps, size_t nearest) {
  const int coset = lattice.coset(layer);
  const bool beyond = layer < lattice.lead || (length_known() && layer > lattice.last_layer - lattice.lead);
  const bool counted = counts_layer(layer), lasting = layer < options.lasting_layers;
  LayerMaker& maker = !counted ? c.uncounted : lasting ? c.lasting : c.maker;
  const uint64_t clamped_before = maker.clamped();
  const double rounded_before = maker.coding_error().squares;
  MadeLayer made = maker.make(lattice.space, coset, taps, nearest, beyond, context, layer_bricks());
  c.slab.push_back(std::move(made.layer));
  c.slab_memory.push_back(std::move(made.memory));
  c.slab_rounded += maker.coding_error().squares - rounded_before;
  if (counted) {
    (lasting ? c.report.lasting.sites_total : c.report.sites_total) += counted_sites(coset);
    const int32_t first = options.part ? options.part->first_own : 0;
    const size_t slab = (layer - first) / options.slab_layers;
    c.report.clamped_slabs.resize(std::max(c.report.clamped_slabs.size(), slab + 1));
    c.report.clamped_slabs[slab] += maker.clamped() - clamped_before;
  }
  const bool last = options.periodic && layer == lattice.last_layer;
  if (last || static_cast<int32_t>(c.slab.size()) == options.slab_layers) hand_out(c);
  if (last) c.slab_index = 0;
}

void Fit::State::hand_out(Channel& c) {
  if (c.slab.empty()) return;
  sink(c.slab_index++, c.index, {c.slab, std::exchange(c.slab_rounded, 0)});
  c.slab.clear();
  c.slab_memory.clear();
}

} // namespace bccsplat
