// SPDX-License-Identifier: Apache-2.0
#include "splat/splat.h"

#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "base/pool.h"
#include "splat/plan/plan_tiles.h"
#include "splat/tile/tile.h"

namespace bccsplat {

DrawStats splat(const SplatScene& scene, const SplatOptions& asked, const Context& context,
                const std::function<void(const TilePixels&)>& emit, KeptSheets* kept) {
  DrawStats stats;
  SplatOptions options = asked;
  if ((options.disable_skips & skip_unchanged) || scene.slice->scattered) kept = nullptr;
  const auto use = kept ? kept->begin_picture(scene, options, context) : KeptSheets::Use::draw;
  // Sheets that are kept are whole.
  if (use != KeptSheets::Use::draw)
    options.disable_skips |= skip_transfer_function | skip_cells | skip_occlusion;
  const KernelPolynomial kernel = kernel_polynomial(scene.slice->kernel.space, options.kernel_form);
  TileObject object{&scene,
                    make_plan(scene, options, context, stats, &context.memory, use != KeptSheets::Use::take),
                    kernel};
  SplatPlan& plan = object.plan;
  // Sheets are taken by the tiles that kept them, which are known without their points.
  if (use == KeptSheets::Use::draw && options.tile_size == 0) divide_tiles(plan, context.tasks.threads());
  stats.tiles = plan.tiles.size();
  if (kept) kept->set_tiles(plan.tiles.size());
  const TileJob job{.objects = std::span(&object, 1),
                    .options = &options,
                    .context = &context,
                    .main = &scene,
                    .kept = kept,
                    .use = use};

  std::mutex mutex; // of stats and done
  Pool<TileMemory> memories;
  uint64_t done = 0;
  // Tiles with more to draw go first, so that none of them runs alone at the end.
  const std::vector<size_t> order = tiles_by_work(plan);
  context.tasks.parallel_for(plan.tiles.size(), [&](uint64_t n) {
    auto memory = memories.take([] { return std::make_unique<TileMemory>(); });
    DrawStats mine;
    emit(draw_tile(job, order[n], nullptr, *memory, mine));
    memories.give_back(std::move(memory));
    double fraction;
    {
      const std::scoped_lock lock(mutex);
      stats += mine;
      fraction = static_cast<double>(++done) / static_cast<double>(plan.tiles.size());
    }
    context.progress.report(fraction);
  });
  if (kept) kept->finish_picture();
  return stats;
}

} // namespace bccsplat
