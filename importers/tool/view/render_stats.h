// SPDX-License-Identifier: Apache-2.0
// Times and counts of a picture, as `bcc4 render --stats` writes them.
#pragma once

#include <string>
#include <vector>

#include "bccsplat.h"
#include "tool/json_fwd.h"

namespace bcc4 {

struct RenderTimes {
  double open_ms = 0;
  bccsplat_slice_info slice{}; // its strings are gone with the slice
  std::string kernel;
  std::vector<bccsplat_render_stats> renders; // of the same picture
};

// Medians of the times; counts are the last render's.
[[nodiscard]] bccsplat_render_stats median_stats(const RenderTimes& times);
[[nodiscard]] Json stats_json(const RenderTimes& times, const bccsplat_volume_info& volume);

} // namespace bcc4
