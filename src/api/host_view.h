// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "bccsplat.h"

#include "scene/host_view.h"

namespace bccsplat::api {

// Reads and checks a view; null: the default one.
[[nodiscard]] HostView read_view(const bccsplat_view* view);

// The tile callback of render options as the core's.
[[nodiscard]] inline FinishedPixels::Tell tile_callback(const bccsplat_render_options& options) {
  if (!options.tile) return {};
  return [tile = options.tile, user = options.tile_user](const PixelRect& r) {
    const auto number = [](int n) { return static_cast<uint32_t>(n); };
    return static_cast<int>(tile(user, number(r.x0), number(r.y0), number(r.x1 - r.x0), number(r.y1 - r.y0)));
  };
}

// A half-space of the world or of the volume's, of one instance or (0) of all.
struct Clip {
  HalfSpace plane;
  bool of_volume = false;
  uint64_t instance = 0;
};
[[nodiscard]] std::vector<Clip> read_clips(const bccsplat_clip* clips, uint64_t count);
// Clips of one slice, without instances, whose world is the volume's.
[[nodiscard]] std::vector<HalfSpace> read_world_clips(const bccsplat_clip* clips, uint64_t count);

} // namespace bccsplat::api
