// SPDX-License-Identifier: Apache-2.0
// Pictures of several volumes, or of one with colours or a mask by other channels: drawn by the library's
// scene, at times of the world.
#pragma once

#include <array>
#include <deque>
#include <optional>
#include <vector>

#include "tool/handles.h"
#include "tool/view/fitted_view.h"
#include "tool/view/picture_sequence.h"
#include "tool/view/render_arguments.h"
#include "tool/view/render_stats.h"
#include "tool/view/transfer_function.h"

namespace bcc4 {

// Refuses what goes with slices of one volume alone.
void check_scene(const RenderArguments& arguments, const std::vector<Picture>& pictures);

// The lights of a picture seen by a camera.
struct Lighting {
  Lighting(const BesideArguments& arguments, const bccsplat_camera& camera);
  [[nodiscard]] bccsplat_lights as_struct() const;

 private:
  const BesideArguments& arguments_;
  std::vector<bccsplat_light> lights_; // none: one from the camera
};

class ScenePictures {
 public:
  // What is given must outlive it. function: of the first volume's channel; none: the library's own.
  // trail_functions: of its trail; none: that one.
  ScenePictures(const Device& device, const Volume& volume, uint32_t channel,
                const RenderArguments& arguments, const std::optional<TransferFunction>& function,
                const std::vector<TransferFunction>& trail_functions);

  // The box of the world around what is seen of the other volumes; none: there are none.
  [[nodiscard]] std::optional<FittedView::Bounds> seen_of_others() const;
  // The colours that a bar shows: those of the channel that says them.
  [[nodiscard]] std::optional<uint32_t> color_channel() const { return color_channel_; }
  [[nodiscard]] const std::vector<std::array<double, 4>>& colors() const { return color_function_->colors; }

  void set_lights(const bccsplat_lights& lights);
  void set_clips(const std::vector<bccsplat_clip>& clips);
  // Sets the trails of a time slice of the first volume. first: the interval of its own, in its frames;
  // index: moments are told by these.
  void set_trails(const Cut& where, bool index, const std::array<double, 2>& first);
  // Draws at a time of the world, into `image`.
  [[nodiscard]] bccsplat_render_stats draw(double time, const bccsplat_view& view, const Image& image,
                                           const bccsplat_render_options& options);

 private:
  // A volume in its place.
  struct Placed {
    const Volume* volume = nullptr;
    uint32_t channel;
    std::optional<TransferFunction> function;      // none: the library's own
    const OtherVolume* other;                      // none: it is the first
    std::vector<TransferFunction> trail_functions; // none: its function
    uint64_t id = 0;                               // 0: it is not in the scene yet
    std::array<double, 2> trail{0, 0};             // in its frames; both 0: it has none
    ClockChange clock{};                           // of times of the first to its own
    std::array<double, 3> lengths{1, 1, 1};        // of its own to those of the first
  };
  void put(Placed& placed);

  const RenderArguments& a_;
  const Volume& volume_;
  bccsplat::client::Scene scene_;
  std::deque<Volume> others_;
  std::vector<Placed> placed_;
  std::optional<uint32_t> color_channel_;
  std::optional<TransferFunction> color_function_;
};

} // namespace bcc4
