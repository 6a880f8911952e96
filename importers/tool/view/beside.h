// SPDX-License-Identifier: Apache-2.0
// What is drawn beside a channel of `bcc4 render`: other volumes with looks of their own, another channel
// that says the colours, one of labels that says what is shown, and light that the volume stands in the way
// of.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "tool/options.h"
#include "tool/view/trail_interval.h"

namespace bcc4 {

// One volume of --with: FILE[,KEY=VALUE...].
struct OtherVolume {
  std::string file, channel, tf, colormap, color_channel;
  std::optional<std::vector<double>> range;
  std::optional<double> opacity;
  double density = 0; // 0: 1
  int32_t look = 0;
  std::array<double, 3> move{};
  std::optional<TrailInterval> trail;
};

struct BesideArguments {
  std::vector<OtherVolume> others;
  std::string color_channel, color_tf, color_colormap, mask_channel;
  std::optional<std::vector<double>> color_range;
  std::vector<double> mask_labels;
  bool shadow = false, occlusion = false;
  std::vector<std::array<double, 3>> lights; // towards each, in the world; none: from the camera

  // Returns whether it takes a scene to draw it.
  [[nodiscard]] bool needs_scene() const {
    return !others.empty() || !color_channel.empty() || !mask_channel.empty();
  }
};

void add_beside(const Command& command, BesideArguments& arguments);
void check_beside(const BesideArguments& arguments);

} // namespace bcc4
