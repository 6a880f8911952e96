// SPDX-License-Identifier: Apache-2.0
#include "choose/wavelet_memory.h"

#include <algorithm>
#include <cmath>

#include "series/value_type.h"
#include "store/settings.h"

namespace bccsplat::series {
namespace {

// The samples of a frame in the tiles that stand for all, which are worked on at a time; more of others only
// where the budget has room.
uint64_t tiles_at_once(const SeriesDescription& s) {
  constexpr uint64_t edge = 64, most = 4;
  uint64_t tiles = 1, samples = 1;
  for (size_t a = 0; a < 3; ++a) tiles *= (s.dims[a] + edge - 1) / edge, samples *= std::min(s.dims[a], edge);
  return std::min(tiles, most) * samples;
}

// Is an error of just the bound one of the values?
bool is_step(const Channel& c, double bound) {
  const double step = source_step(c), steps = bound / (step > 0 ? step : 1);
  return bound > 0 && step > 0 && std::fabs(steps - std::nearbyint(steps)) < .01;
}

} // namespace

uint64_t memory_of_wavelets(const SeriesDescription& s, const WriterSettings& settings, double bound) {
  constexpr uint64_t of_tile_sample = 20, of_frame_sample = 4; // while it is coded; on its way to a layer
  constexpr uint64_t reach = 10, of_field_sample = 20;         // layers on either side; the field of a frame
  const uint64_t samples = s.dims[0] * s.dims[1] * s.dims[2];
  const uint64_t layers =
      std::min<uint64_t>(s.dims[3], slab_layers_of_wavelets(LatticeKind::cc, static_cast<double>(samples)));
  const uint64_t waiting = std::min(s.dims[3], layers + 2 * reach);
  uint64_t sample = 0, levels = 0; // bytes of one
  for (const Channel& c : s.channels) {
    const int32_t type = stored_type(c, settings);
    const uint64_t source = type_size(c.type), code = type == BCCSPLAT_TYPE_U8 ? 1 : 2;
    const bool waits = is_step(c, bound), as_given = source == code && !is_float(c.type);
    const uint64_t held = waits ? waiting : layers;
    sample += layers * code + held * code + (waits || !as_given ? held * source : 0);
    sample += (waits ? of_field_sample : 0) + 2 * source + of_frame_sample; // in use, and read ahead
    levels += layers * (source + 2 * code) / 6;
  }
  return samples * (sample + (settings.levels > 0 ? levels : 0)) + tiles_at_once(s) * layers * of_tile_sample;
}

} // namespace bccsplat::series
