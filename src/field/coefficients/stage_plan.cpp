// SPDX-License-Identifier: Apache-2.0
#include "field/coefficients/stage_plan.h"

#include <algorithm>
#include <climits>

namespace bccsplat {
namespace {

// Returns how many planes along each axis a stage looks at on either side, of what the stage before made and
// of the samples; -1: it does not read these.
int reach_of_previous(const PrefilterStage& f, bool bcc) {
  return f.spatial != 0 || f.mixed != 0 || (bcc && f.cross != 0) ? 1 : 0;
}
int reach_of_samples(const PrefilterStage& f, bool bcc) {
  if (!f.uses_source() && (bcc || f.cross == 0)) return -1;
  return f.source_spatial != 0 || f.source_mixed != 0 || (!bcc && f.cross != 0) ? 1 : 0;
}

} // namespace

StagePlan::StagePlan(const Prefilter& filter, std::span<const int32_t> layers) : wanted_(layers.size()) {
  place(filter);
  const auto needed = filter.needed(layers);
  for (size_t s = 0; s < needed.size(); ++s) {
    const bool last = s + 1 == needed.size();
    std::vector<int32_t> order(needed[s].begin(), needed[s].end());
    if (last) order.assign(layers.begin(), layers.end());
    for (const int32_t m : order) {
      ring_of_[{static_cast<int>(s), m}] = rings_.size();
      if (s == 0) samples_.push_back({m, rings_.size()});
      rings_.push_back(add_ring(depths_[s]));
      if (s > 0) nodes_.push_back(node_of(filter, static_cast<int>(s), m));
    }
  }
  for (Node& n : nodes_) {
    if (n.neighbour_inputs > 0) n.neighbours = add_ring(3);
    if (!n.cross.empty()) n.corners = add_ring(n.span + 1);
  }
}

// A plane is made as soon as what it reads has been made: stage s is margins_[s] planes ahead of the last
// one. Sums over planes are made when the furthest of them is there, and only sums look back.
void StagePlan::place(const Prefilter& filter) {
  const auto& steps = filter.steps_;
  const bool bcc = filter.lattice_.space.bcc;
  margins_.assign(steps.size() + 1, 0);
  std::vector<int> lowest(steps.size() + 1, INT_MAX); // that is read, seen from the plane of the last stage
  for (size_t s = steps.size(); s > 0; --s) {
    const auto& [stage, source] = steps[s - 1];
    const auto read = [&](size_t from, int reach) {
      if (reach < 0) return;
      margins_[from] = std::max(margins_[from], margins_[s] + reach);
      lowest[from] = std::min(lowest[from], margins_[s]);
    };
    read(s - 1, reach_of_previous(stage, bcc));
    read(source, reach_of_samples(stage, bcc));
  }
  margin_ = margins_[0];
  for (size_t s = 0; s <= steps.size(); ++s)
    depths_.push_back(margins_[s] - std::min(lowest[s], margins_[s]) + 1);
}

StagePlan::Ring StagePlan::add_ring(int depth) {
  const Ring ring{depth, planes_};
  planes_ += depth;
  return ring;
}

StagePlan::Node StagePlan::node_of(const Prefilter& filter, int stage, int32_t m) const {
  const Lattice4& lattice = filter.lattice_;
  const auto& [f, source] = filter.steps_[static_cast<size_t>(stage) - 1];
  Node node;
  node.margin = margins_[stage];
  node.layer = m;
  node.ring = ring_of_.at({stage, m});
  const auto add = [&](int from, int32_t layer, double centre, double neighbours) {
    if (centre == 0 && neighbours == 0) return;
    node.inputs.push_back({ring_of_.at({from, lattice.mirror_layer(layer)}), static_cast<float>(centre),
                           static_cast<float>(neighbours)});
  };
  const auto add_layers = [&](int from, double self, double spatial, double temporal, double mixed) {
    add(from, m, self, spatial);
    if (lattice.is_static()) return;
    for (const int32_t d : {-lattice.layer_period(), lattice.layer_period()})
      add(from, m + d, temporal, mixed);
  };
  add_layers(stage - 1, f.self, f.spatial, f.temporal, f.mixed);
  add_layers(source, f.source, f.source_spatial, f.source_temporal, f.source_mixed);
  const auto split = std::stable_partition(node.inputs.begin(), node.inputs.end(),
                                           [](const Node::Input& i) { return i.neighbours != 0; });
  node.neighbour_inputs = split - node.inputs.begin();
  if (f.cross == 0) return node;
  node.cross_weight = static_cast<float>(f.cross);
  if (!lattice.space.bcc) {
    node.cross = {ring_of_.at({source, m})};
    node.shift = -1, node.span = 2;
    return node;
  }
  node.shift = lattice.coset(m) == 1 ? 0 : -1;
  for (const int32_t d : {-1, 1})
    if (d > 0 || !lattice.is_static())
      node.cross.push_back(ring_of_.at({stage - 1, lattice.mirror_layer(m + d)}));
  return node;
}

} // namespace bccsplat
