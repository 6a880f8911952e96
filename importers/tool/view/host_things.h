// SPDX-License-Identifier: Apache-2.0
// What a picture shares with other programs: their matrices, what they cut open, their own picture with its
// depths.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "bccsplat.h"

namespace bcc4 {

// Linear premultiplied RGBA, 4 floats per pixel; depth as planar distance in the world, or empty: all of it
// is behind.
struct HostPicture {
  uint32_t width = 0, height = 0;
  std::vector<float> rgba, depth;
};

struct HostThings {
  // Matrices and their conventions; none: a camera.
  std::optional<bccsplat_view> matrices;
  std::optional<std::array<uint32_t, 2>> resolution; // of the matrices' file
  std::vector<bccsplat_clip> clips;
  std::optional<HostPicture> over;

  // The view of a picture by the matrices or this camera, which are looked into while it is used.
  [[nodiscard]] bccsplat_view view(const bccsplat_camera& camera) const;
};

// "a,b,c,d": keeps a x + b y + c z + d >= 0.
[[nodiscard]] bccsplat_clip parse_clip(const std::string& text);
// "x0,y0,z0,x1,y1,z1": six half-spaces.
[[nodiscard]] std::vector<bccsplat_clip> parse_box(const std::string& text);
// {"world_to_view": [16], "projection": [16], "depth": "0..1" | "-1..1" | "reversed", "y_down": false,
// "resolution": [w, h]}, row-major for columns; the last three may be missing.
void read_view_matrices(const std::string& path, HostThings& out);
// An OpenEXR file of R, G, B, A and perhaps Z or, as bcc4 writes it, depth.Z.
[[nodiscard]] HostPicture read_host_picture(const std::string& path);

} // namespace bcc4
