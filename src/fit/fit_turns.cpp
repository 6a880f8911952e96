// SPDX-License-Identifier: Apache-2.0
// The layers of a periodic series. Frames and layers are counted on beyond its end, and the first layers,
// which need the last frames, are made there.
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "fit/fit_state.h"

namespace bccsplat {

// It begins with the first whole slab whose layers need no frame before the first one there is; all layers
// need the last frames where there is none.
void Fit::State::begin_turn() {
  if (options.lowpass) turn.first_frame = lowpass_time_reach(lattice);
  const int reach = filter_reach(time_widening(lattice));
  const double needed = turn.first_frame + reach - 1.0;
  const auto layer = static_cast<int64_t>(std::ceil(needed / lattice.time_step));
  const int64_t slab = (layer + options.slab_layers - 1) / options.slab_layers * options.slab_layers;
  if (slab < lattice.layers()) turn.first_layer = static_cast<int32_t>(slab);
  const double last = std::ceil(lattice.layer_frame(turn.first_layer)) + reach + 1;
  const double frames = slab < lattice.layers() ? std::max(last - turn.first_frame, 0.0) : options.dims[3];
  turn.head_frames = static_cast<uint32_t>(std::min<double>(frames, options.dims[3]));
}

void Fit::State::begin_turn(Channel& c) const {
  c.frames = c.window_first = turn.first_frame;
  c.next_layer = turn.first_layer;
  c.slab_index = turn.first_layer / options.slab_layers;
}

const FrameSites& Fit::State::frame_at(const Channel& c, int64_t f) const {
  return f < c.window_first ? c.head.at(f - turn.first_frame) : c.frame(f);
}

void Fit::State::make_turning_layers(Channel& c, bool complete) {
  const double widening = time_widening(lattice);
  for (; c.next_layer < end_layer(); ++c.next_layer) {
    const double position = lattice.layer_frame(c.next_layer);
    const FilterTable table = filter_table(widening, std::span(&position, 1));
    const int64_t begin = table.first[0], end = begin + table.taps;
    if (!complete && (begin < turn.first_frame || end > c.frames)) break;
    std::vector<std::pair<int64_t, float>> frames;
    for (int64_t f = begin; f < end; ++f) frames.emplace_back(f, table.weight[f - begin]);
    weigh_gaps(frames, [&](int64_t f) -> const FrameSites& { return frame_at(c, counted_frame(f)); });
    std::vector<LayerTap> taps;
    std::map<int64_t, size_t> tap_of; // by frame: a short series turns several times within the filter
    for (const auto& [f, weight] : frames) {
      const auto [at, is_new] = tap_of.try_emplace(counted_frame(f), taps.size());
      if (is_new) taps.push_back({&frame_at(c, at->first), 0});
      taps[at->second].weight += weight;
    }
    const auto nearest = tap_of.find(counted_frame(lattice.nearest_frame(position)));
    emit(c, lattice.mirror_layer(c.next_layer), taps, nearest == tap_of.end() ? 0 : nearest->second);
  }
  turn_frames(c);
}

void Fit::State::turn_frames(Channel& c) const {
  const auto needed = static_cast<int64_t>(std::floor(lattice.layer_frame(c.next_layer))) -
                      filter_reach(time_widening(lattice));
  while (c.window.size() > 1 && c.window_first < needed) {
    if (c.window_first - turn.first_frame < turn.head_frames) c.head.push_back(std::move(c.window.front()));
    c.forget_first();
  }
}

} // namespace bccsplat
