// Cameras as JSON: {"position": [x,y,z], "target": [x,y,z], "up": [x,y,z], "fovy_deg": d or "ortho_height":
// h, "resolution": [w,h]}, in world space, right-handed.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "bccsplat.h"

namespace bcc4 {

struct CameraFile {
  bccsplat_camera camera{};
  std::optional<std::array<uint32_t, 2>> resolution;
};
[[nodiscard]] CameraFile read_camera_file(const std::string& path);

} // namespace bcc4
