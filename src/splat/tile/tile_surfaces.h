// SPDX-License-Identifier: Apache-2.0
// The isosurfaces of a tile: where its rays pass the values between two sheets, in order along each ray, and
// what they add to its pixels.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "shade/iso_surface.h"
#include "shade/surface.h"
#include "splat/sheet/sheet.h"
#include "splat/tile/sheet_source.h"
#include "splat/tile/tile.h"

namespace bccsplat {

class TileSurfaces {
 public:
  // Everything passed must outlive it. The pixels' planes and rays are those of `pixel` at each call.
  TileSurfaces(const TileJob& job, const PlannedTile& tile, TileMemory& memory, const SurfaceField& field,
               const SheetSource& source, const PixelPlanes& pixel);

  // Finds the surfaces between the sheets k - 1 and k, for each k of [first, end), and composites them.
  // Returns the number of pixels that closed.
  int draw(int64_t first, int64_t end, DrawStats& stats);

 private:
  struct Surface {
    double target; // relative to the base
    float value, opacity;
    std::array<float, 4> color;
    bool both_ways; // what lies behind it is seen: rays that graze it leave it again
    bool own_color; // not that of a value
  };
  struct Found {
    size_t begin = 0, end = 0; // in the memory's crossings
  };
  struct Hit {
    uint32_t pixel = 0, surface = 0;
    double i = 0, j = 0;
    SurfacePoint point;
    std::array<float, 4> color{};
  };

  [[nodiscard]] bool look_at(int64_t first, int64_t end, DrawStats& stats, CrossingArgs& c) const;
  void find_crossings(CrossingArgs& c);
  void refine(const CrossingArgs& c, uint32_t surface, int interval);
  [[nodiscard]] bool lacks_points(double k, int x, int y, float value, float target) const;
  void paint(std::span<Hit> hits) const;
  bool add(const Hit& hit);

  const SplatScene& scene_;
  const SplatOptions& options_;
  const SplatPlan& plan_;
  const PlannedTile& tile_;
  TileMemory& m_;
  const SurfaceField& field_;
  std::optional<SurfaceField> paint_; // whose values say the colours
  const SheetSource& source_;
  const PixelPlanes& pixel_;
  const SheetView& view_;
  const SheetLoops& loops_;
  TimeField time_;
  float stop_;
  std::vector<Surface> surfaces_;
  std::vector<Found> found_; // by surface
  std::vector<Hit> hits_;    // of one interval
};

} // namespace bccsplat
