#include "splat/trail/trail.h"

#include <algorithm>
#include <memory>
#include <mutex>

#include "splat/tile/tile.h"
#include "splat/trail/trail_memory.h"

namespace bccsplat {
namespace {

// Whether the rays run inside both domains alike.
bool same_domain(const SplatScene& a, const SplatScene& b) {
  return a.view == b.view && a.slice->domain_begin == b.slice->domain_begin &&
         a.slice->domain_end == b.slice->domain_end && a.slice->clip.empty() && b.slice->clip.empty();
}

TrailObject plan_object(const SplatScene& scene, const SplatScene& main, const SplatOptions& options,
                        Tasks& tasks, SplatStats& stats) {
  SplatOptions at_pixels = options; // the objects of a trail share one grid of samples
  at_pixels.raise = {};
  return {&scene, make_plan(scene, at_pixels, tasks, stats),
          kernel_polynomial(scene.slice->kernel.space, options.kernel_form), !same_domain(scene, main)};
}

// A finished picture over another, in place.
TilePixels over(const TilePixels& front, const TilePixels& back, TrailMemory& memory) {
  float* const base = memory.pixels.data(); // of `back`
  const auto writable = [&](const float* plane) { return plane ? base + (plane - base) : nullptr; };
  float *const red = writable(back.red), *const green = writable(back.green),
               *const blue = writable(back.blue);
  float *const alpha = writable(back.alpha), *const depth = writable(back.depth);
  for (int y = 0; y < back.height; ++y)
    for (int x = 0; x < back.width; ++x) {
      const auto p = static_cast<size_t>(y) * static_cast<size_t>(back.pitch) + static_cast<size_t>(x);
      const auto f = static_cast<size_t>(y) * static_cast<size_t>(front.pitch) + static_cast<size_t>(x);
      const float a = front.alpha[f], b = (1 - a) * back.alpha[p], sum = a + b;
      const auto mean = [&](float* plane, const float* of) { // NaN where a picture has nothing
        if (plane) plane[p] = sum > 0 ? ((a > 0 ? a * of[f] : 0) + (b > 0 ? b * plane[p] : 0)) / sum : of[f];
      };
      mean(writable(back.value), front.value), mean(writable(back.time), front.time);
      red[p] = front.red[f] + (1 - a) * red[p], green[p] = front.green[f] + (1 - a) * green[p],
      blue[p] = front.blue[f] + (1 - a) * blue[p];
      alpha[p] = sum;
      depth[p] = std::min(depth[p], front.depth[f]);
    }
  return back;
}

} // namespace

SplatStats splat_with_trail(const SplatScene& slice, std::span<const SplatScene> sources,
                            std::span<const TrailStill> stills, TrailCombine combine,
                            const SplatOptions& options, const Context& context,
                            const std::function<void(const TilePixels&)>& emit) {
  SplatOptions alone = options; // one grid of tiles for all
  if (alone.tile_size == 0) alone.tile_size = trail_tile_size;
  SplatOptions together = alone;
  together.mode = RenderMode::composite;
  alone.with_deep = false; // what is drawn apart goes into the trail's picture
  const bool post = combine == TrailCombine::post;
  const bool apart = post || options.mode == RenderMode::isosurface;

  std::vector<TrailObject> objects(1 + sources.size());
  std::vector<SplatStats> planned(objects.size());
  context.tasks.parallel_for(objects.size(), [&](uint64_t n) {
    objects[n] = n == 0 ? plan_object(slice, slice, apart ? alone : together, context.tasks, planned[0])
                        : plan_object(sources[n - 1], slice, together, context.tasks, planned[n]);
  });
  SplatStats stats;
  for (const SplatStats& s : planned) {
    stats.points_after_cull += s.points_after_cull;
    stats.bricks_invisible += s.bricks_invisible, stats.bricks_outside += s.bricks_outside;
    stats.sheets = std::max(stats.sheets, s.sheets);
  }
  const std::vector<PlannedTile>& tiles = objects[0].plan.tiles;
  stats.tiles = tiles.size();
  TrailJob job;
  job.slice = apart ? nullptr : &objects[0];
  job.sources = std::span(objects).subspan(1);
  job.stills = stills;
  job.combine = post ? TrailCombine::physical : combine;
  job.options = &together, job.context = &context, job.main = &slice;
  const TileJob alone_job{&slice, &alone, &objects[0].plan, &objects[0].kernel, &context};

  std::mutex mutex;
  TrailMemoryPool pool(context.memory);
  struct Loan {
    TrailMemoryPool& pool;
    std::unique_ptr<TrailMemoryPool::Held> held;
    ~Loan() { pool.give_back(std::move(held)); }
  };
  uint64_t done = 0;
  context.tasks.parallel_for(tiles.size(), [&](uint64_t n) {
    const Loan loan{pool, pool.take(tile_bytes(job, apart ? &objects[0] : nullptr, n))};
    TrailMemory* const memory = &loan.held->memory;
    SplatStats mine;
    if (apart) {
      const TilePixels front = draw_tile(alone_job, tiles[n], memory->slice, mine);
      const TilePixels trail = draw_trail_tile(job, n, tiles[n], post ? nullptr : &front, *memory, mine);
      emit(post ? over(front, trail, *memory) : trail);
    } else {
      emit(draw_trail_tile(job, n, tiles[n], nullptr, *memory, mine));
    }
    double fraction;
    {
      const std::scoped_lock lock(mutex);
      add(stats, mine);
      fraction = static_cast<double>(++done) / static_cast<double>(tiles.size());
    }
    context.progress.report(fraction);
  });
  return stats;
}

} // namespace bccsplat
