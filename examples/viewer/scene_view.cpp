// SPDX-License-Identifier: Apache-2.0
#include "viewer/scene_view.h"

#include <algorithm>
#include <iterator>

namespace viewer {

SceneView::SceneView(bccsplat_device* device, const bccsplat_volume* volume, std::array<double, 2> range)
    : volume_(volume), range_(range) {
  auto info = sized<bccsplat_volume_info>();
  check(bccsplat_volume_get_info(volume, &info));
  last_frame_ = static_cast<double>(info.dims[3] - 1);
  bccsplat_scene* made = nullptr;
  check(bccsplat_scene_create(device, &made));
  scene_.reset(made);
  check(bccsplat_scene_add(made, volume, nullptr, &instance_));
  check(bccsplat_scene_get_bounds(made, box_));
  check(bccsplat_volume_get_side(volume, &side_));
}

double SceneView::time_at(double frame) const {
  double time = 0;
  check(bccsplat_volume_index_to_time(volume_, std::clamp(frame, 0.0, last_frame_), &time));
  return time;
}

void SceneView::apply(const Wish& wish) {
  // What is set anew begins the picture anew.
  if (!any_ || wish.palette != applied_.palette || wish.opacity != applied_.opacity) {
    const Look look(wish, range_);
    auto instance = sized<bccsplat_instance>();
    instance.outside = BCCSPLAT_OUTSIDE_HOLD;
    instance.transfer_function = &look.function;
    check(bccsplat_scene_set_instance(scene_.get(), instance_, &instance));
  }
  if (!any_ || wish.open != applied_.open || wish.open_to != applied_.open_to) {
    const std::vector<bccsplat_clip> clips = clips_of(wish, box_);
    check(bccsplat_scene_set_clips(scene_.get(), clips.data(), clips.size()));
  }
  check(bccsplat_scene_set_time(scene_.get(), time_at(wish.frame)));
  applied_ = wish, any_ = true;
}

bccsplat_camera camera_of_box(const Wish& wish, bccsplat_side side, const double (&box)[6]) {
  auto fit = sized<bccsplat_fit>();
  fit.side = side;
  fit.rotate_x_degrees = wish.rotate_x, fit.rotate_y_degrees = wish.rotate_y;
  std::copy(std::begin(box), std::end(box), fit.bounds);
  auto camera = sized<bccsplat_camera>();
  check(bccsplat_fit_camera(&fit, wish.width, wish.height, &camera));
  camera.ortho_height /= wish.zoom;
  return camera;
}

bccsplat_camera SceneView::camera(const Wish& wish) const { return camera_of_box(wish, side_, box_); }

bccsplat_scene_status SceneView::draw(const Wish& wish, const bccsplat_render_options& options,
                                      double budget_ms, bccsplat_frame* frame) const {
  const bccsplat_camera seen_by = camera(wish);
  auto view = sized<bccsplat_view>();
  view.camera = &seen_by;
  auto status = sized<bccsplat_scene_status>();
  check(bccsplat_scene_render(scene_.get(), &view, frame, &options, budget_ms, &status));
  return status;
}

void SceneView::read(const Wish& wish) const {
  const bccsplat_camera seen_by = camera(wish);
  auto view = sized<bccsplat_view>();
  view.camera = &seen_by;
  const Options of(wish, BCCSPLAT_QUALITY_DRAFT, nullptr);
  (void)bccsplat_scene_prefetch(scene_.get(), &view, wish.width, wish.height, &of.options,
                                time_at(wish.frame));
}

} // namespace viewer
