// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "bccsplat.h"

#include "scene/host_view.h"

namespace bccsplat::api {

// Reads and checks a view; null: the default one.
[[nodiscard]] HostView read_view(const bccsplat_view* view);

// A half-space of the world or of the volume's, of one instance or (0) of all.
struct Clip {
  HalfSpace plane;
  bool of_volume = false;
  uint64_t instance = 0;
};
[[nodiscard]] std::vector<Clip> read_clips(const bccsplat_clip* clips, uint64_t count);
// Those of one slice, without instances, whose world is the volume's.
[[nodiscard]] std::vector<HalfSpace> read_world_clips(const bccsplat_clip* clips, uint64_t count);

} // namespace bccsplat::api
