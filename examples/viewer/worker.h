// SPDX-License-Identifier: Apache-2.0
// Makes pictures in a thread of their own: the newest wish wins, a draft comes first, the fine picture when
// nothing moves.
#pragma once

#include "viewer/surfaces.h"

#include <bccsplat.hpp>

#include <array>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <future>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace viewer {

using bccsplat::client::Handle;
using bccsplat::client::sized;

struct Cancelled {};
// Throws what went wrong, or Cancelled when a newer wish ended the call.
void check(bccsplat_status status);

constexpr int curve_points = 9; // of the transfer function, evenly spread over the range of values

// Everything a picture depends on.
struct Wish {
  double frame = 0;
  std::array<double, 3> tilt{}; // frames later from one end of x, y, z to the other
  double rotate_x = 20, rotate_y = 30, zoom = 1;
  std::array<float, curve_points> opacity{};
  int palette = 0;
  bool iso = false; // the surfaces instead of the transfer function's opacities
  std::vector<Surface> surfaces;
  bool trail = false;
  double trail_frames = 4;
  bool playing = false; // drafts only, and what the next moment needs is made meanwhile
  double step = 0;      // to the next moment, about
  int width = 0, height = 0;
  bool operator==(const Wish&) const = default;
};

struct Picture {
  Wish wish;                    // that it fulfils
  std::vector<uint32_t> pixels; // RGBA bytes, sRGB over black
  std::vector<float> rgba;      // linear, as it was drawn
  Handle<bccsplat_frame> frame; // of rgba
  int width = 0, height = 0;
  bool fine = false;
  bccsplat_render_stats stats{};
  bccsplat_slice_info slice{};
  std::string error; // instead of pixels
};

struct Counts {
  std::atomic<int> drafts{0}, fine{0}, cancelled{0};
};

class Worker {
 public:
  Worker(bccsplat_device* device, const bccsplat_volume* volume, std::array<double, 2> range);
  ~Worker();
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  // Called from the window's thread; cancels what is under way for an older wish. Returns false when the wish
  // is the one before.
  bool wish(const Wish& wish);
  // Returns the newest picture, if there is one that was not taken yet.
  [[nodiscard]] std::unique_ptr<Picture> take();
  [[nodiscard]] const Counts& counts() const { return counts_; }

 private:
  void run();
  void draw(const Wish& wish, bool fine);
  void cut(const Wish& wish, uint32_t level);
  // The view of the wish, and the level of the file that a picture of it needs.
  [[nodiscard]] bccsplat_camera camera(const Wish& wish) const;
  [[nodiscard]] uint32_t level(const Wish& wish, const bccsplat_camera& camera,
                               const bccsplat_render_options& options) const;
  void look_ahead(const Wish& wish);
  void classify(const Wish& wish);
  void set_options(const Wish& wish, bccsplat_render_options& options);

  bccsplat_device* device_;
  const bccsplat_volume* volume_;
  std::array<double, 2> range_;
  // Cancelled with each newer wish, and reset when that is taken up: both while mutex_ is held, so that no
  // wish is ended by its own coming.
  Handle<bccsplat_cancel_token> token_;
  Handle<bccsplat_renderer> renderer_;
  Handle<bccsplat_slice> slice_;
  Wish drawn_;                        // what slice and renderer are set to
  uint32_t coarsest_ = 0, level_ = 0; // levels of the file, and of the slice
  bool slice_is_made_ = false;
  Counts counts_;

  std::mutex mutex_;
  std::condition_variable changed_;
  Wish wish_;
  std::unique_ptr<Picture> picture_;
  bool newer_ = false, stop_ = false; // a wish that was not taken up yet
  std::future<void> ahead_;           // what the next moment of a series that plays needs
  std::thread thread_;
};

} // namespace viewer
