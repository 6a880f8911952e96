// SPDX-License-Identifier: Apache-2.0
#include "scene/together.h"

#include <algorithm>
#include <deque>
#include <limits>
#include <vector>

#include "base/error.h"
#include "draw/deep.h"
#include "scene/merge_deep.h"
#include "scene/settled_picture.h"

namespace bccsplat {
namespace {

// Draws what shares its sheets; false, and nothing is drawn, where slices have no sheets in common.
bool draw_by_sheets(std::span<const Scene> scenes, const RenderOptions& options, const Context& context,
                    Image& image) {
  std::deque<SettledPicture> pictures;
  double apart = std::numeric_limits<double>::infinity(), least = 0; // between sheets
  for (const Scene& scene : scenes) {
    SettledPicture& picture = pictures.emplace_back(scene, options, context, image);
    picture.settle_level();
    apart = std::min(apart, picture.sheets_apart()), least = std::max(least, picture.least_apart());
  }
  if (least > apart) return false;
  std::vector<const Shot*> shots;
  for (SettledPicture& picture : pictures) {
    picture.settle_view(apart);
    picture.settle_look();
    picture.settle_drawer();
    shots.push_back(&picture.shot());
  }
  const SheetView& view = *shots.front()->view;
  if (image.deep) *image.deep = {}; // gives its memory back first
  DeepCollector deep(context.memory);
  draw_together(shots, context, [&](const TilePixels& tile) {
    write_tile(tile, view, image);
    if (tile.deep) deep.add(tile, view, context.progress);
    tell_drawn(tile, image);
  });
  if (image.deep) *image.deep = deep.collect(image.width, image.height, context.progress);
  return true;
}

void draw_merged(std::span<const Scene> scenes, const RenderOptions& options, const Context& context,
                 Image& image) {
  const auto share = [&](size_t n) { return static_cast<double>(n) / static_cast<double>(scenes.size()); };
  std::vector<DeepImage> deep(scenes.size());
  std::vector<const DeepImage*> all;
  // A picture's own planes are not looked at.
  const Reservation memory(context.memory,
                           sizeof(float) * 4 * static_cast<uint64_t>(image.width) * image.height,
                           "a picture of several instances");
  ImageStorage scratch(image.width, image.height);
  for (size_t n = 0; n < scenes.size(); ++n) {
    scratch.image.deep = &deep[n];
    Progress part(context.progress, share(n), share(n + 1));
    (void)render(scenes[n], options, context.with(part), scratch.image);
    all.push_back(&deep[n]);
  }
  merge_deep(all, std::min(options.depth_opacity, options.opacity_stop), context, image);
  image.tell_all_drawn();
}

} // namespace

void render_together(std::span<const Scene> scenes, const RenderOptions& options, const Context& context,
                     Image& image) {
  if (image.value.pixels || image.time.pixels)
    fail(Code::unsupported, "render: values and times of several instances have no place in one picture");
  for (const Scene& scene : scenes) check_picture(scene, options, image);
  if (options.backend == Backend::gpu)
    fail(Code::unsupported, "render: the GPU does not draw several instances; let the CPU draw them");
  RenderOptions by_cpu = options;
  by_cpu.backend = Backend::cpu;
  if (options.mode == RenderMode::composite && !options.reference &&
      draw_by_sheets(scenes, by_cpu, context, image))
    return;
  if (image.deep)
    fail(Code::unsupported, "render: a deep picture of several instances is of mode composite, and of "
                            "lattices of like spacing");
  draw_merged(scenes, by_cpu, context, image);
}

} // namespace bccsplat
