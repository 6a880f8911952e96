// SPDX-License-Identifier: Apache-2.0
#include "scene/host_view.h"

#include "base/error.h"

namespace bccsplat {

std::array<int, 2> HostView::picture_size(int width, int height) const {
  if (picture[0] == 0) return {width, height};
  if (begin[0] + width > picture[0] || begin[1] + height > picture[1])
    fail(Code::invalid_argument, "view: a frame of ", width, " x ", height, " at (", begin[0], ", ", begin[1],
         ") is no part of a picture of ", picture[0], " x ", picture[1]);
  return picture;
}

Sight HostView::sight(const Camera& fitted, int width, int height) const {
  const auto [whole_width, whole_height] = picture_size(width, height);
  const Sight whole = matrices ? sight_of(*matrices, whole_width, whole_height)
                               : make_sight(camera.value_or(fitted), whole_width, whole_height);
  return picture[0] == 0 ? whole : whole.region(begin[0], begin[1]);
}

Camera fitted_camera(const HostView& view, const Slice& slice, int width, int height) {
  if (!view.is_default()) return {};
  const auto [whole_width, whole_height] = view.picture_size(width, height);
  return fit_camera(slice, false, default_rotate_x, default_rotate_y, whole_width, whole_height);
}

HostEnds::HostEnds(const HostView& view, Sight& sight, int width, int height, MemoryBudget& budget) {
  if (!view.depth.pixels) return;
  memory = Reservation(budget, sizeof(float) * static_cast<uint64_t>(width) * height, "depths of the host");
  DeviceDepth device;
  if (view.depth_kind == DepthKind::device) device = device_depth(*view.matrices);
  distance = ray_ends(view.depth, view.depth_kind, device, view.matrices && view.matrices->reversed, sight,
                      width, height);
  sight.ends = {distance.data(), static_cast<size_t>(width)};
}

void lay_over(const HostPlane& background, const PixelRect& pixels, Image& image) {
  if (!background.pixels || !image.rgba.pixels) return; // a texture has none
  for (int y = pixels.y0; y < pixels.y1; ++y) {
    const float* behind = background.row(y, image.width, 4) + std::ptrdiff_t{4} * pixels.x0;
    float* pixel = image.rgba.at(pixels.x0, y);
    for (int x = pixels.x0; x < pixels.x1; ++x, behind += 4, pixel += 4) {
      const float passes = 1 - pixel[3];
      for (int c = 0; c < 4; ++c) pixel[c] += passes * behind[c];
    }
  }
}

FinishedPixels::FinishedPixels(const HostPlane& background, const Tell& tell, Progress& progress,
                               Image& image)
    : background_(background), tell_(tell), progress_(progress), image_(image),
      drawn_([this](const PixelRect& pixels) { finish(pixels); }) {
  image.drawn = &drawn_;
}

void FinishedPixels::finish(const PixelRect& pixels) {
  any_.store(true, std::memory_order_relaxed);
  lay_over(background_, pixels, image_);
  if (!tell_) return;
  const std::scoped_lock lock(telling_);
  progress_.throw_if_cancelled(); // by the answer to another one
  if (tell_(pixels) != 0) progress_.cancel();
  progress_.throw_if_cancelled();
}

} // namespace bccsplat
