// SPDX-License-Identifier: Apache-2.0
#include "gpu/gpu_rows.h"

#include <algorithm>

#include "base/grid.h"

namespace bccsplat {

std::vector<float> packed_ends(const SheetView& view) {
  std::vector<float> out;
  if (!view.ends.distance) return out;
  constexpr float far = 1e30f; // instead of infinity, of which GPUs need not know
  for (int j = 0; j < view.height; ++j)
    for (int i = 0; i < view.width; ++i) out.push_back(std::clamp(view.ends.at(i, j), -far, far));
  return out;
}

uint64_t picture_bytes(const Shot& shot) {
  return (2 * sizeof(Vec4f) + sizeof(float)) * plane_size(shot.view->width, shot.view->height);
}

GpuPixels draw_all_rows(GpuDevice& device, GpuPicture& picture, const Shot& shot, const Context& context) {
  const int height = shot.view->height, rows = picture.rows_at_once();
  for (int row = 0; row < height; row += rows) {
    context.progress.report(static_cast<double>(row) / height);
    device.run([&] { picture.draw_rows(row, std::min(rows, height - row)); });
  }
  GpuPixels pixels;
  const ShotOptions& o = shot.options;
  device.run([&] {
    if (shot.target)
      picture.lay_over(device.programs(), *shot.target);
    else
      pixels = picture.read(o.with_depth || o.with_value || o.with_time);
  });
  return pixels;
}

} // namespace bccsplat
