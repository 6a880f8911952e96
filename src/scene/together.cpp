// SPDX-License-Identifier: Apache-2.0
// Settles the slices, and has them drawn by a GPU, by sheets that they share, or as deep pictures that are
// merged.
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

// Slices that share their sheets, settled but for their drawers.
class SharedSheets {
 public:
  SharedSheets(std::span<const Scene> scenes, const RenderOptions& options, const Context& context,
               Image& image)
      : context_(context), image_(image) {
    double apart = std::numeric_limits<double>::infinity(), least = 0; // between sheets
    for (const Scene& scene : scenes) {
      SettledPicture& picture = pictures_.emplace_back(scene, options, context, image);
      picture.settle_level();
      apart = std::min(apart, picture.sheets_apart()), least = std::max(least, picture.least_apart());
    }
    there_ = least <= apart;
    for (SettledPicture& picture : pictures_) {
      if (!there_) return;
      picture.settle_view(apart);
      picture.settle_look();
      picture.settle_paint();
      picture.settle_light();
      picture.settle_trail();
      shots_.push_back(&picture.shot());
    }
  }
  // Whether they have sheets in common.
  [[nodiscard]] bool there() const { return there_; }
  [[nodiscard]] std::span<const Shot* const> shots() const { return shots_; }

  void draw_by_cpu() {
    for (SettledPicture& picture : pictures_) picture.settle_drawer();
    const SheetView& view = *shots_.front()->view;
    if (image_.deep) *image_.deep = {}; // gives its memory back first
    DeepCollector deep(context_.memory);
    draw_together(shots_, context_, [&](const TilePixels& tile) {
      write_tile(tile, view, image_);
      if (tile.deep) deep.add(tile, view, context_.progress);
      tell_drawn(tile, image_);
    });
    if (image_.deep) *image_.deep = deep.collect(image_.width, image_.height, context_.progress);
  }
  void draw_by_gpu(Drawers& drawers) {
    const SheetView& view = *shots_.front()->view;
    drawers.draw_together_by_gpu(shots_, context_, [&](const TilePixels& tile) {
      write_tile(tile, view, image_);
      tell_drawn(tile, image_);
    });
  }

 private:
  const Context& context_;
  Image& image_;
  std::deque<SettledPicture> pictures_;
  std::vector<const Shot*> shots_;
  bool there_ = false;
};

// Draws by a GPU, where it does; false, and nothing is drawn, where it does not.
bool draw_by_gpu(SharedSheets& shared, std::span<const Scene> scenes, const RenderOptions& options,
                 RenderStats& stats) {
  Drawers of_picture;
  Drawers& drawers = scenes.front().drawers ? *scenes.front().drawers : of_picture;
  if (!drawers.gpu_draws_together(shared.shots(), {false, options.backend, options.gpu})) return false;
  try {
    shared.draw_by_gpu(drawers);
    stats.drawer = "gpu";
    return true;
  } catch (const GpuFailure& e) {
    if (options.backend == Backend::gpu || !has_cpu_drawers) throw;
    stats.gpu_failed = e.message();
    note_failure(options.gpu.get(), e);
  }
  return false;
}

// Draws what shares its sheets; false, and nothing is drawn, where slices have no sheets in common.
bool draw_by_sheets(std::span<const Scene> scenes, const RenderOptions& options, const Context& context,
                    Image& image, RenderStats& stats) {
  RenderOptions by_cpu = options;
  by_cpu.backend = Backend::cpu;
  SharedSheets shared(scenes, by_cpu, context, image);
  if (!shared.there()) return false;
  if (!draw_by_gpu(shared, scenes, options, stats)) shared.draw_by_cpu(), stats.drawer = "sheets";
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
  for (const Scene& scene : scenes) {
    check_picture(scene, options, image);
    if (scene.trail && scene.combine == TrailCombine::post)
      fail(Code::unsupported,
           "render: a trail that is laid under a finished picture has no place among several "
           "instances; combine it in depth");
  }
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
