// SPDX-License-Identifier: Apache-2.0
// Keeps what the pixels of an isosurface met, tile by tile, and smooths its edges when all are there.
#pragma once

#include <mutex>
#include <vector>

#include "base/context.h"
#include "draw/image.h"
#include "draw/smooth_edges.h"
#include "draw/tile_pixels.h"

namespace bccsplat {

class EdgeSmoother {
 public:
  // wanted: else nothing is kept or smoothed. Tiles of several surfaces, or transparent ones, have to come
  // with their hits, which the options are told.
  EdgeSmoother(bool wanted, const Context& context, const Image& image, ShotOptions& options);

  // Returns whether tiles have to come with their hits.
  [[nodiscard]] static bool needs_hits(const ShotOptions& options);
  // Returns whether pixels will be drawn again.
  [[nodiscard]] bool at_work() const { return layered_ || !picture_.k.empty(); }
  void add(const TilePixels& tile); // from any thread
  // Tells the image of what it has drawn, where it is at work.
  EdgeStats smooth(const Shot& shot, const Context& context);

 private:
  struct Part {
    Reservation memory;
    std::vector<SurfaceHit> hits; // by pixel of the picture
  };
  void list_hits(const Context& context);

  bool layered_ = false;
  const Image& image_;
  MemoryBudget& budget_;
  Reservation memory_, list_memory_;
  SurfacePicture picture_;
  std::mutex mutex_;
  std::vector<Part> parts_;
};

} // namespace bccsplat
