// SPDX-License-Identifier: Apache-2.0
// Cameras as JSON: {"position": [x,y,z], "target": [x,y,z], "up": [x,y,z], "fovy_deg": d or "ortho_height":
// h, "resolution": [w,h], "frames": [{...}, ...]}, in world space, right-handed. Each of the frames is a
// camera of its own, with the outer one's keys where it has none.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "bccsplat.h"

namespace bcc4 {

struct CameraFile {
  std::vector<bccsplat_camera> cameras; // of the frames; else one
  std::optional<std::array<uint32_t, 2>> resolution;
};
[[nodiscard]] CameraFile read_camera_file(const std::string& path);

// The camera on a circle about its target, `degrees` about its up direction, right-handed as --rotate-y.
[[nodiscard]] bccsplat_camera turned(const bccsplat_camera& camera, double degrees);

// Makes what is seen grow by the factor about the middle of the picture.
[[nodiscard]] bccsplat_camera zoomed(const bccsplat_camera& camera, double factor);

} // namespace bcc4
