// SPDX-License-Identifier: Apache-2.0
// A view as a host gives it: its camera or matrices, the part of the picture that is drawn, and the opaque
// things around.
#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <mutex>
#include <optional>
#include <vector>

#include "base/memory.h"
#include "base/progress.h"
#include "draw/image.h"
#include "view/camera.h"
#include "view/host_depth.h"

namespace bccsplat {

struct HostView {
  std::optional<Camera> camera; // neither: the default view
  std::optional<MatrixView> matrices;
  std::array<int, 2> picture{}, begin{}; // picture 0: the image is all of it
  HostPlane depth, background;           // the latter of 4 floats
  DepthKind depth_kind = DepthKind::planar;

  [[nodiscard]] bool is_default() const { return !camera && !matrices; }
  // Size of the whole picture that an image of this size is a part of. Throws invalid_argument where it is
  // none.
  [[nodiscard]] std::array<int, 2> picture_size(int width, int height) const;
  // What an image of this size sees; `fitted` is the camera of the default view.
  [[nodiscard]] Sight sight(const Camera& fitted, int width, int height) const;
};

// The angles of the default view, degrees.
inline constexpr double default_rotate_x = 20, default_rotate_y = 30;

// Returns the camera of the default view of a slice; that of another view has none that counts.
[[nodiscard]] Camera fitted_camera(const HostView& view, const Slice& slice, int width, int height);

// The ends of rays that a sight points to.
struct HostEnds {
  std::vector<float> distance;
  Reservation memory;

  // Gives the sight the ends that the view's depth plane tells, if it has one. Throws memory_budget.
  HostEnds(const HostView& view, Sight& sight, int width, int height, MemoryBudget& budget);
};

// Lays pixels of the picture over the background: premultiplied colours and opacity.
void lay_over(const HostPlane& background, const PixelRect& pixels, Image& image);

// Finishes what is drawn of a picture, rectangle by rectangle: lays it over the host's background, then tells
// the host, one rectangle at a time. The host's answer other than 0 cancels.
class FinishedPixels {
 public:
  using Tell = std::function<int(const PixelRect&)>; // may be empty
  // All of these outlive it; the image tells it from now on.
  FinishedPixels(const HostPlane& background, const Tell& tell, Progress& progress, Image& image);
  ~FinishedPixels() { image_.drawn = nullptr; }
  FinishedPixels(const FinishedPixels&) = delete;
  FinishedPixels& operator=(const FinishedPixels&) = delete;
  // Whether the image is no longer what it was.
  [[nodiscard]] bool any() const { return any_; }

 private:
  void finish(const PixelRect& pixels);

  const HostPlane& background_;
  const Tell& tell_;
  Progress& progress_;
  Image& image_;
  PixelsDrawn drawn_;
  std::mutex telling_;
  std::atomic<bool> any_{false};
};

} // namespace bccsplat
