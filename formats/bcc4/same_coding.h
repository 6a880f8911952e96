// SPDX-License-Identifier: Apache-2.0
// Whether two files hold layers of the same places in the same code.
#pragma once

#include <algorithm>

#include "formats/bcc4/info.h"

namespace bccsplat {

[[nodiscard]] inline bool same_layers(const StoredLattice& a, const StoredLattice& b) {
  return a.slab_layers == b.slab_layers && a.tile_edge == b.tile_edge && a.lattice.kind == b.lattice.kind &&
         a.lattice.space == b.lattice.space && a.lattice.time_step == b.lattice.time_step &&
         a.lattice.lead == b.lattice.lead && a.lattice.periodic == b.lattice.periodic;
}

// Returns whether two infos agree in what may not change once samples are written.
[[nodiscard]] inline bool same_coding(const VolumeInfo& a, const VolumeInfo& b) {
  if (a.channels.size() != b.channels.size() || a.levels.size() != b.levels.size()) return false;
  for (int l = 0; l < a.level_count(); ++l)
    if (!same_layers(a.level(l), b.level(l))) return false;
  return std::equal(a.channels.begin(), a.channels.end(), b.channels.begin(),
                    [](const ChannelInfo& x, const ChannelInfo& y) {
                      return static_cast<const Quantiser&>(x) == static_cast<const Quantiser&>(y) &&
                             x.wavelet_error == y.wavelet_error && x.linear == y.linear;
                    });
}

} // namespace bccsplat
