// SPDX-License-Identifier: Apache-2.0
// The pixels of a tile while they are drawn.
#pragma once

namespace bccsplat {

// Planes of the pixels of a tile, `pitch` floats per row.
struct PixelPlanes {
  // What has been composited: premultiplied colour and opacity; depth in sheet steps where the opacity passed
  // 1/2; sums weighted by opacity.
  float *red = nullptr, *green = nullptr, *blue = nullptr, *alpha = nullptr;
  float *depth = nullptr, *value = nullptr, *time = nullptr; // value, time: null when not asked for
  // The ray: sheet numbers where it enters and leaves the domain, world length per sheet step, direction to
  // the viewer.
  const float *enter = nullptr, *leave = nullptr, *path = nullptr;
  const float *view_x = nullptr, *view_y = nullptr, *view_z = nullptr;
};

} // namespace bccsplat
