// SPDX-License-Identifier: Apache-2.0
// Makes pictures in a thread of their own: the newest wish wins, a coarse picture comes first, the fine one
// when nothing moves.
#pragma once

#include "viewer/reader.h"
#include "viewer/scene_view.h"

#include <array>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace viewer {

struct Picture {
  Wish wish;                    // that it fulfils
  std::vector<uint32_t> pixels; // RGBA bytes, sRGB over black
  std::vector<float> rgba;      // linear, as it was drawn
  Handle<bccsplat_frame> frame; // of rgba
  int width = 0, height = 0;
  bool fine = false;
  bccsplat_scene_status scene{}; // of a moment, which a scene drew
  bccsplat_render_stats stats{}; // of another plane, or with a trail
  bccsplat_slice_info slice{};
  std::string error; // instead of pixels
};

struct Counts {
  std::atomic<int> drafts{0}, fine{0}, cancelled{0};
  std::atomic<uint64_t> waited_for{0}; // bytes that a picture was kept waiting for while the series played
  std::atomic<bool> by_gpu{false};     // the last picture
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
  // A picture to draw into, which is shown once it is handed over.
  [[nodiscard]] std::unique_ptr<Picture> begin(const Wish& wish, bool fine) const;
  void show(std::unique_ptr<Picture> picture);
  void draw_scene(const Wish& wish);
  // Draws a series that plays: waits for nothing, and is called again when what the moment needs was read.
  void draw_playing(const Wish& wish);
  // The last moment in the view of a wish, unless that is what is shown.
  void draw_meanwhile(const Wish& wish);
  void draw_draft(const Wish& wish);
  // Other planes, and trails.
  void draw(const Wish& wish, bool fine);
  void cut(const Wish& wish, uint32_t level);
  // The view of the wish, and the level of the file that a picture of it needs.
  [[nodiscard]] bccsplat_camera camera(const Wish& wish) const;
  [[nodiscard]] uint32_t level(const Wish& wish, const bccsplat_camera& camera,
                               const bccsplat_render_options& options) const;

  bccsplat_device* device_;
  const bccsplat_volume* volume_;
  std::array<double, 2> range_;
  // Cancelled with each newer wish, and reset when that is taken up: both while mutex_ is held, so that no
  // wish is ended by its own coming.
  Handle<bccsplat_cancel_token> token_;
  SceneView scene_;
  Handle<bccsplat_renderer> renderer_;
  Handle<bccsplat_slice> slice_;
  Wish drawn_;                        // what slice and renderer are set to
  std::optional<Wish> played_;        // what a draft was drawn of while the series played
  uint32_t coarsest_ = 0, level_ = 0; // levels of the file, and of the slice
  bool slice_is_made_ = false;
  Counts counts_;

  std::mutex mutex_;
  std::condition_variable changed_;
  Wish wish_;
  std::unique_ptr<Picture> picture_;
  bool newer_ = false, stop_ = false; // a wish that was not taken up yet
  std::unique_ptr<Reader> reader_;
  std::thread thread_;
};

} // namespace viewer
