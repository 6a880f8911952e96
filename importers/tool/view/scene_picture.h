// SPDX-License-Identifier: Apache-2.0
// Pictures of several volumes, or of one with colours or a mask by other channels: drawn by the library's
// scene, at times of the world.
#pragma once

#include <array>
#include <deque>
#include <optional>

#include "tool/handles.h"
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
  ScenePictures(const Device& device, const Volume& volume, uint32_t channel,
                const RenderArguments& arguments, const std::optional<TransferFunction>& function);

  // The fitted view of all volumes; none: there is one, which is looked at as without a scene.
  [[nodiscard]] std::optional<bccsplat_camera> fitted(int32_t projection, const std::array<uint32_t, 2>& size,
                                                      double turn) const;
  // The colours that a bar shows: those of the channel that says them.
  [[nodiscard]] std::optional<uint32_t> color_channel() const { return color_channel_; }
  [[nodiscard]] const std::vector<std::array<double, 4>>& colors() const { return color_function_->colors; }

  void set_lights(const bccsplat_lights& lights);
  void set_clips(const std::vector<bccsplat_clip>& clips);
  // Draws at a time of the world, into `image`.
  [[nodiscard]] bccsplat_render_stats draw(double time, const bccsplat_view& view, const Image& image,
                                           const bccsplat_render_options& options);

 private:
  void add(const Volume& volume, uint32_t channel, const std::optional<TransferFunction>& function,
           const OtherVolume* other);

  const RenderArguments& a_;
  bccsplat::client::Scene scene_;
  std::deque<Volume> others_;
  std::optional<uint32_t> color_channel_;
  std::optional<TransferFunction> color_function_;
};

} // namespace bcc4
