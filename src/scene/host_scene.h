// SPDX-License-Identifier: Apache-2.0
// Volumes in a host's world: what a picture of them needs is chosen, cut, kept, and drawn.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "scene/host_view.h"
#include "scene/picture.h"
#include "scene/trail.h"
#include "volume/open_slice.h"

namespace bccsplat {

// What an instance shows at times outside its series.
enum class Outside : uint8_t { hide, hold, loop };

struct Instance {
  const OpenVolume* volume = nullptr;
  uint32_t channel = 0;
  Affine3 placement; // from the volume's world to the scene's
  double time_scale = 1, time_offset = 0;
  Outside outside = Outside::hide;
  bool hidden = false;
  std::optional<TransferFunction> function; // none: the channel's look
  double density = 1;                       // what its extinction is multiplied by
  // Another channel of the volume whose values say the colours, by this function or by its look.
  std::optional<uint32_t> color_channel;
  std::optional<TransferFunction> color_function;
  // A channel of labels: what is of none of these is not drawn.
  std::optional<uint32_t> mask_channel;
  std::vector<double> mask_labels;
  std::optional<AskedTrail> trail; // what moved

  // Returns whether the same slices are cut of it.
  [[nodiscard]] bool cut_like(const Instance& o) const {
    return channel == o.channel && color_channel == o.color_channel && mask_channel == o.mask_channel &&
           mask_labels == o.mask_labels && trail.has_value() == o.trail.has_value() &&
           (!trail || trail->options == o.trail->options);
  }
};

// A half-space of the scene's world, or of the world of each volume.
struct SceneClip {
  HalfSpace plane;
  bool of_volume = false;
  uint64_t instance = 0; // 0: all
};

struct ScenePicture {
  HostView view;
  RenderOptions options;
  std::optional<double> gradient_noise; // as noise_of() takes it
  double budget_ms = 0;                 // 0: until it is complete
  Drawers* drawers = nullptr;           // null: those that each cut keeps
};

struct SceneStats {
  bool complete = true, drew = false; // drew: the image was written
  double progress = 1;
  uint32_t drawn = 0, cut = 0, level = 0;
  uint64_t bytes_read = 0;
  double ms_cut = 0, ms_draw = 0, ms_total = 0;
  RenderStats picture; // of the instances, of several but what drew them; of a budget the last part
};

struct SceneCut; // host_scene_parts.h

// The volumes outlive it. All calls but const ones need it alone, and those but prefetch_requests() find
// nobody who changes it.
class HostScene {
 public:
  HostScene();
  ~HostScene();
  // Returns the instance's number, from 1 on.
  uint64_t add(const Instance& instance);
  // These throw not_found where there is no such instance.
  void set(uint64_t id, const Instance& instance);
  void remove(uint64_t id);
  [[nodiscard]] const Instance& instance(uint64_t id) const;

  void set_time(double time) { time_ = time; }
  void set_clips(std::vector<SceneClip> clips);
  void set_lights(Lights lights) { lights_ = std::move(lights), ++version_; }

  // The box around the instances that are not hidden, and a camera for it. Throw wrong_state where all are.
  [[nodiscard]] WorldBox bounds() const;
  [[nodiscard]] Camera fit(bool perspective, double rotate_x, double rotate_y, int width, int height) const;
  // Tells the image of what is drawn (FinishedPixels), of a picture with a budget first of all that there is,
  // then of what this call finishes. Throws what cutting and drawing do; of a budget that ends nothing but
  // what the picture itself is refused for.
  SceneStats render(const ScenePicture& picture, const Context& context, Image& image);
  // What a picture at a time will need: the cuts that it is made of, and their instances. May be called while
  // another thread uses or changes the scene.
  struct Prefetch {
    uint64_t instance = 0;
    SliceRequest request;
  };
  [[nodiscard]] std::vector<Prefetch> prefetch_requests(const ScenePicture& picture, double at, int width,
                                                        int height) const;

 private:
  struct Placed;
  struct Need;
  struct Frame;
  class Budget;
  using CutOf = std::unique_ptr<SceneCut> Placed::*;

  [[nodiscard]] Placed& find(uint64_t id) const;
  // In the scene's world, of what bounds() and fit() are around.
  [[nodiscard]] std::vector<Vec3> corners() const;
  [[nodiscard]] Sight sight_of(const ScenePicture& picture, int width, int height) const;
  // What an instance is seen by: cut by its clips.
  [[nodiscard]] Sight sight_of(uint64_t id, const Sight& sight) const;
  // What a sight shows of the instances at a time.
  [[nodiscard]] std::vector<Need> needs(const Sight& sight, const RenderOptions& options, double at,
                                        int width, int height) const;
  [[nodiscard]] static std::unique_ptr<SceneCut> cut_anew(const Need& need, const Context& context,
                                                          SceneStats& stats);
  void cut(const Need& need, std::unique_ptr<SceneCut>& into, const Context& context,
           SceneStats& stats) const;
  [[nodiscard]] bool cut_within(double ms, std::span<const Need> shown, CutOf into, const Context& context,
                                SceneStats& stats) const;
  void draw(const ScenePicture& picture, std::span<const Need> shown, CutOf cut_of, const Context& context,
            Image& image, SceneStats& stats) const;
  [[nodiscard]] bool draw_coarse(const ScenePicture& picture, const Sight& sight, double ms,
                                 const Context& context, const Image& image, SceneStats& stats);
  void show_rows(int begin, int end, const Image& image, SceneStats& stats) const;
  void draw_band(const ScenePicture& picture, std::span<const Need> shown, int begin, int end,
                 const Context& context, const Image& image, SceneStats& stats);
  void draw_bands(const ScenePicture& picture, std::span<const Need> shown, const Budget& budget,
                  const Context& context, const Image& image, SceneStats& stats);
  void draw_within(const ScenePicture& picture, const Sight& sight, std::span<const Need> shown,
                   std::chrono::steady_clock::time_point start, const Context& context, Image& image,
                   SceneStats& stats);

  mutable std::mutex changing_; // what needs() looks at, beside what prefetches from another thread
  std::map<uint64_t, std::unique_ptr<Placed>> instances_;
  uint64_t next_ = 1, version_ = 0; // the latter of all that a picture shows but the time
  double time_ = 0;
  std::vector<SceneClip> clips_;
  Lights lights_;
  std::unique_ptr<Frame> frame_; // that calls with a budget are at work on
};

} // namespace bccsplat
