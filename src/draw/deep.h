// SPDX-License-Identifier: Apache-2.0
// A deep picture: what each pixel holds along its ray, put together from the tiles.
#pragma once

#include <cstdint>
#include <mutex>
#include <vector>

#include "base/memory.h"
#include "base/paged_vector.h"
#include "base/progress.h"
#include "draw/tile_pixels.h"
#include "view/view.h"

namespace bccsplat {

// Samples of a pixel are in order of depth and do not overlap; composited front to back they are the flat
// picture.
struct DeepImage {
  static constexpr size_t components = 6; // Z, ZBack, A, R, G, B: world distance along the view direction
                                          // from the camera, opacity, premultiplied colour
  std::vector<uint64_t> first;            // of pixel p = y width + x: first[p] .. first[p + 1] - 1
  PagedVector<float> samples;             // `components` each
  Reservation memory;
};

// Tiles come from any thread and in any order.
class DeepCollector {
 public:
  explicit DeepCollector(MemoryBudget& memory) : memory_(memory) {}
  void add(const TilePixels& tile, const SheetView& view, Progress& progress); // throws cancelled
  // Throws memory_budget, cancelled. Until it returns, the samples are held twice.
  [[nodiscard]] DeepImage collect(int width, int height, Progress& progress);

 private:
  struct Part {
    int x, y, width, height;
    std::vector<uint32_t> counts; // per pixel
    PagedVector<float> samples;
    Reservation memory;
  };
  MemoryBudget& memory_;
  std::mutex mutex_;
  std::vector<Part> parts_;
};

} // namespace bccsplat
