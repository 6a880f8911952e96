// SPDX-License-Identifier: Apache-2.0
// What drawing a picture took, and what of it was left out.
#pragma once

#include <algorithm>
#include <cstdint>

namespace bccsplat {

struct DrawStats {
  double ms_transform = 0, ms_splat = 0, ms_shade = 0; // summed over threads
  uint64_t points_after_cull = 0, points_splatted = 0, points_occluded = 0;
  uint64_t points_invisible = 0; // visits of points in cells that nothing visible looks at
  uint64_t bricks_total = 0, bricks_invisible = 0, bricks_outside = 0, sheets_skipped = 0;
  // Visits of tiles to bricks that are neither invisible nor outside; of these, to bricks that finished
  // pixels hide when they are come to, and to those that the tile was done without.
  uint64_t brick_visits = 0, visits_hidden = 0, visits_unread = 0;
  uint64_t sheets_taken = 0;  // of tiles, from those that were kept
  uint64_t contributions = 0; // window samples (pixels x sheets) the splat loop went through
  uint64_t tiles = 0, sheets = 0;
  uint64_t points_total = 0;  // of all that is drawn; by rays its sites, without mirror images
  bool preintegrated = false; // by integrals of the transfer function
  // What went to a GPU for the picture: bytes of sites, and layers of a series among them.
  uint64_t bytes_sent = 0, layers_sent = 0;

  [[nodiscard]] double ms() const { return ms_transform + ms_splat + ms_shade; }
  // Adds what a tile or an object of the same picture counted: all of them share its tiles and sheets, and
  // what is known of the picture as a whole.
  DrawStats& operator+=(const DrawStats& part) {
    ms_transform += part.ms_transform, ms_splat += part.ms_splat, ms_shade += part.ms_shade;
    points_after_cull += part.points_after_cull, points_splatted += part.points_splatted;
    points_occluded += part.points_occluded, points_invisible += part.points_invisible;
    bricks_total += part.bricks_total;
    bricks_invisible += part.bricks_invisible, bricks_outside += part.bricks_outside;
    brick_visits += part.brick_visits, visits_hidden += part.visits_hidden;
    visits_unread += part.visits_unread;
    sheets_skipped += part.sheets_skipped, sheets_taken += part.sheets_taken;
    contributions += part.contributions;
    tiles = std::max(tiles, part.tiles), sheets = std::max(sheets, part.sheets);
    return *this;
  }
};

} // namespace bccsplat
