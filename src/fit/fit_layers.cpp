// SPDX-License-Identifier: Apache-2.0
// Makes each layer as soon as its frames are there: the filter in time over the frames in its reach, those
// beyond the ends of the series replaced by predictions or mirror images.
#include <algorithm>
#include <cmath>
#include <utility>

#include "fit/axis/site_axis.h"
#include "fit/fit_state.h"

namespace bccsplat {

// Makes the layers; with one frame of an unknown number the lattice is not known yet.
void Fit::State::make_layers(Channel& c) {
  if (!length_known() && c.frames < 2) return;
  if (lattice.is_static()) return make_still_layers(c);
  const int64_t frames = finished ? int64_t{c.frames} : length_known() ? int64_t{options.dims[3]} : INT32_MAX;
  const bool complete = c.frames == frames + turn.first_frame;
  if (!complete && waits_for_data(c)) return;
  if (options.periodic) return make_turning_layers(c, complete);
  make_moving_layers(c, frames, complete);
}

bool Fit::State::waits_for_data(const Channel& c) const {
  const int64_t there = int64_t{c.frames} - turn.first_frame;
  return !c.any_known &&
         there <= 2 * filter_reach(time_widening(lattice)) + (options.lead > 0 ? ends.used() : 0);
}

void Fit::State::make_still_layers(Channel& c) {
  for (; c.frames > 0 && c.next_layer < lattice.layers(); ++c.next_layer) {
    const LayerTap tap{&c.window.front(), 1};
    emit(c, c.next_layer, {&tap, 1}, 0);
  }
}

void Fit::State::make_moving_layers(Channel& c, int64_t frames, bool complete) {
  const double widening = time_widening(lattice);
  for (; !length_known() || c.next_layer < end_layer(); ++c.next_layer) {
    const FilterTable table = layer_table(lattice, c.next_layer, length_known(), widening);
    int64_t end = table.first[0] + table.taps;
    if (table.first[0] < 0) end = std::max(end, options.lead > 0 ? ends.used() : 0);
    if (!complete && end > c.frames) break;
    // Frames not yet known to end are not continued beyond their end; the first ones are in the same way for
    // any number.
    const int64_t n = complete ? frames : int64_t{c.frames};
    const int64_t nearest = nearest_sample(lattice.layer_frame(c.next_layer), n);
    std::vector<LayerTap> taps;
    size_t nearest_tap = 0;
    for (const auto& [f, weight] : weighted_frames(c, table, n)) {
      if (f == nearest) nearest_tap = taps.size();
      taps.push_back({&c.frame(f), weight});
    }
    emit(c, c.next_layer, taps, nearest_tap);
  }
  forget_frames(c, c.frames);
}

std::vector<std::pair<int64_t, float>> Fit::State::weighted_frames(Channel& c, const FilterTable& table,
                                                                   int64_t n) {
  std::vector<std::pair<int64_t, float>> list;
  if (options.lead > 0)
    list = ends.inside(table, n, [&](bool last) { return end_level(c, last, n); });
  else
    for (int k = 0; k < table.taps; ++k)
      list.emplace_back(mirror_index(table.first[0] + k, n), table.weight[k]);
  weigh_gaps(list, [&](int64_t f) -> const FrameSites& { return c.frame(f); });
  return list;
}

uint8_t Fit::State::end_level(Channel& c, bool last, int64_t n) const {
  if (ends.levels() == 1) return 0;
  if (options.fixed_predictions) return usual_noise_level;
  std::optional<uint8_t>& level = c.end_levels[last ? 1 : 0];
  if (level) return *level;
  std::vector<const FrameSites*> frames;
  for (int64_t k = 0; k < std::min(n, ends.used()); ++k) frames.push_back(&c.frame(last ? n - 1 - k : k));
  level = choose_end_level(frames, lattice.space, time_widening(lattice));
  return *level;
}

void Fit::State::forget_made(Channel& c, size_t kept) {
  while (c.window.size() > kept && int64_t{c.window_first} < c.next_layer) c.forget_first();
}

void Fit::State::forget_frames(Channel& c, int64_t frames) const {
  if (layers_are_frames()) return forget_made(c, 1); // missing frames take what the last one holds
  const int reach = filter_reach(time_widening(lattice));
  // The table of the last layer begins earlier (layer_table).
  const bool before_last = length_known() && c.next_layer < lattice.last_layer;
  const auto direct = before_last
                          ? layer_table(lattice, c.next_layer, true, time_widening(lattice)).first[0]
                          : static_cast<int64_t>(std::floor(lattice.layer_frame(c.next_layer))) - reach;
  const auto mirrored = frames - 2 - reach - static_cast<int64_t>(std::ceil(lattice.time_step));
  const int64_t predicted = frames - ends.used();
  const int64_t needed = std::min(direct, options.lead > 0 ? predicted : mirrored);
  while (!c.window.empty() && c.window_first < needed) c.forget_first();
}

} // namespace bccsplat
