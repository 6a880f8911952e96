// SPDX-License-Identifier: Apache-2.0
#include "draw/edge_smoother.h"

#include <algorithm>

#include "base/grid.h"

namespace bccsplat {

EdgeSmoother::EdgeSmoother(bool wanted, const Context& context, const Image& image, ShotOptions& options)
    : image_(image), budget_(context.memory) {
  if (!wanted || options.mode != RenderMode::isosurface || options.surfaces.empty()) return;
  const size_t pixels = plane_size(image.width, image.height);
  layered_ = options.with_hits = needs_hits(options);
  memory_ = Reservation(budget_, pixels * (layered_ ? sizeof(size_t) : sizeof(float)),
                        "the depths of a surface's edges");
  picture_ = {image.width, image.height, {}, {}, {}, image.rgba.pixels, image.rgba.row_floats};
  if (layered_)
    picture_.first.assign(pixels + 1, 0);
  else
    picture_.k.resize(pixels);
}

bool EdgeSmoother::needs_hits(const ShotOptions& options) {
  return options.mode == RenderMode::isosurface &&
         (options.surfaces.size() > 1 || sees_through(options.surfaces));
}

void EdgeSmoother::add(const TilePixels& tile) {
  if (layered_) {
    const size_t columns = picture_.width, pitch = tile.pitch;
    Part part{Reservation(budget_, tile.hits.size_bytes(), "the hits of a surface's rays"),
              {tile.hits.begin(), tile.hits.end()}};
    for (SurfaceHit& hit : part.hits)
      hit.pixel = static_cast<uint32_t>((tile.y + hit.pixel / pitch) * columns + tile.x + hit.pixel % pitch);
    const std::scoped_lock lock(mutex_);
    parts_.push_back(std::move(part));
  } else if (!picture_.k.empty()) {
    for (int y = 0; y < tile.height; ++y)
      std::copy_n(tile.depth + plane_offset(0, y, tile.pitch), tile.width,
                  picture_.k.begin() + plane_offset(tile.x, tile.y + y, picture_.width));
  }
}

// Sorts the hits of all tiles by pixel; those of one stay in order.
void EdgeSmoother::list_hits(const Context& context) {
  size_t count = 0;
  for (const Part& part : parts_) count += part.hits.size();
  list_memory_ = Reservation(context.memory, count * sizeof(SurfaceHit), "the hits of a surface's rays");
  std::vector<size_t>& first = picture_.first;
  for (const Part& part : parts_)
    for (const SurfaceHit& hit : part.hits) ++first[hit.pixel + size_t{1}];
  for (size_t p = 1; p < first.size(); ++p) first[p] += first[p - 1];
  picture_.hits.resize(count);
  // The beginning of each list runs to its end, which is where the next one begins.
  for (const Part& part : parts_)
    for (const SurfaceHit& hit : part.hits) picture_.hits[first[hit.pixel]++] = hit;
  std::copy_backward(first.begin(), first.end() - 1, first.end());
  first.front() = 0;
  parts_.clear();
}

EdgeStats EdgeSmoother::smooth(const Shot& shot, const Context& context) {
  if (layered_)
    list_hits(context);
  else if (picture_.k.empty())
    return {};
  return smooth_edges(shot, picture_, context, [this](const PixelRect& rows) { image_.tell_drawn(rows); });
}

} // namespace bccsplat
