// SPDX-License-Identifier: Apache-2.0
// Settles the slices, and has them drawn as one picture, by a GPU or by sheets that they share, or as deep
// pictures that are merged.
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
                    Image& image, RenderStats& stats) {
  std::deque<SettledPicture> pictures;
  double apart = std::numeric_limits<double>::infinity(), least = 0; // between sheets
  for (const Scene& scene : scenes) {
    SettledPicture& picture = pictures.emplace_back(scene, options, context, image);
    picture.settle_level();
    apart = std::min(apart, picture.sheets_apart()), least = std::max(least, picture.least_apart());
  }
  if (least > apart) return false;
  SettledPicture& first = pictures.front();
  for (SettledPicture& picture : pictures) {
    picture.settle_view(apart);
    picture.settle_look();
    picture.settle_paint();
    picture.settle_light();
    picture.settle_trail();
    if (&picture != &first) first.join(picture);
  }
  first.settle_drawer();
  if (image.deep) *image.deep = {}; // gives its memory back first
  stats = first.draw();
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
  // The depth of surfaces is that of the first hit.
  const double depth_opacity = options.mode == RenderMode::isosurface ? 0 : options.depth_opacity;
  merge_deep(all, std::min(depth_opacity, options.opacity_stop), context, image);
  image.tell_all_drawn();
}

} // namespace

RenderStats render_together(std::span<const Scene> scenes, const RenderOptions& options,
                            const Context& context, Image& image) {
  if (options.mode == RenderMode::xray || options.mode == RenderMode::maximum)
    fail(Code::unsupported, "render: several instances are drawn in modes composite and isosurface");
  if (image.value.pixels || image.time.pixels)
    fail(Code::unsupported, "render: values and times of several instances have no place in one picture");
  for (const Scene& scene : scenes) check_picture(scene, options, image);
  RenderStats stats;
  if (options.mode == RenderMode::composite && !options.reference &&
      draw_by_sheets(scenes, options, context, image, stats))
    return stats;
  if (image.deep)
    fail(Code::unsupported, "render: a deep picture of several instances is of mode composite, and of "
                            "lattices of like spacing");
  if (options.backend == Backend::gpu)
    fail(Code::unsupported, "render: the GPU does not draw several instances in this mode, or of so unlike "
                            "spacing; let the CPU draw them");
  RenderOptions by_cpu = options;
  by_cpu.backend = Backend::cpu;
  draw_merged(scenes, by_cpu, context, image);
  stats.drawer = "sheets";
  return stats;
}

} // namespace bccsplat
