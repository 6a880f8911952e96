// SPDX-License-Identifier: Apache-2.0
// A moment of the series, drawn by a scene: within some milliseconds a coarse picture, in calls that follow
// the complete one.
#pragma once

#include "viewer/wish.h"

#include <array>

namespace viewer {

// A view of a box of the world from a side, as the wish turns it.
[[nodiscard]] bccsplat_camera camera_of_box(const Wish& wish, bccsplat_side side, const double (&box)[6]);

class SceneView {
 public:
  SceneView(bccsplat_device* device, const bccsplat_volume* volume, std::array<double, 2> range);

  // Sets what has changed since the last wish.
  void apply(const Wish& wish);
  // budget_ms 0: until it is complete.
  [[nodiscard]] bccsplat_scene_status draw(const Wish& wish, const bccsplat_render_options& options,
                                           double budget_ms, bccsplat_frame* frame) const;
  // Reads what the draft of a wish needs. Another thread may draw meanwhile. What fails is told by the
  // picture.
  void read(const Wish& wish) const;
  [[nodiscard]] const double (&box() const)[6] { return box_; }
  [[nodiscard]] bccsplat_camera camera(const Wish& wish) const;

 private:
  [[nodiscard]] double time_at(double frame) const;

  const bccsplat_volume* volume_;
  std::array<double, 2> range_;
  double last_frame_ = 0;
  double box_[6] = {};
  bccsplat_side side_ = BCCSPLAT_SIDE_FRONT;
  Handle<bccsplat_scene> scene_;
  uint64_t instance_ = 0;
  bool any_ = false;
  Wish applied_;
};

} // namespace viewer
