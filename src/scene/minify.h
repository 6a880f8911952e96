// SPDX-License-Identifier: Apache-2.0
// Pictures smaller than the data: where a pixel covers more than one lattice distance, a coarser slice
// (slice/coarsen.h) is drawn. Nothing aliases, and the cost falls with the picture.
#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "base/context.h"
#include "field/slice.h"
#include "splat/points/kept_points.h"
#include "view/camera.h"

namespace bccsplat {

// The coarser levels of one slice: made on first use, one from the other, and kept.
class CoarseLevels {
 public:
  struct Level {
    Slice slice;
    KeptPoints points;
    Reservation memory;
  };
  // Level n >= 1 has 2^n times the lattice distance of `base`, which must be the same slice at every call.
  // Concurrent calls are allowed. Throws memory_budget, cancelled.
  [[nodiscard]] const Level& level(const Slice& base, int n, const Context& context) const;
  // Follows the base, which stands elsewhere in the world from now on. While no other call is under way.
  void place(const Affine3& slice_to_world);

 private:
  mutable std::mutex mutex_;
  mutable std::vector<std::unique_ptr<Level>> levels_; // [n - 1]
};

// What pictures of a slice keep with it.
struct SliceKeep {
  KeptPoints points;   // as sheets need them
  CoarseLevels levels; // for small pictures
};

// Returns the level for a picture: n while a pixel at the centre of the domain covers 2^n to 2^(n+1) lattice
// distances of the slice; 0, the slice itself, below two. From two on aliasing costs more than the low pass
// does (`bccsplat_bench render --minify`). No level has fewer than four planes per axis.
[[nodiscard]] int minification_level(const Slice& slice, const SliceView& view);
[[nodiscard]] inline int minification_level(const Slice& slice, const Camera& camera, int width, int height) {
  return minification_level(slice, SliceView(slice, resolve_camera(camera), width, height));
}

} // namespace bccsplat
