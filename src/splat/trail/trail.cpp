// SPDX-License-Identifier: Apache-2.0
// Draws a slice with its trail: plans all objects on one grid of tiles, with tiles small enough for every
// thread to find memory for one, and has each tile drawn. Where the slice is drawn apart, as a surface or a
// picture of its own, it is drawn first; a surface then ends the trail's rays, and a picture is laid over the
// trail's.
#include "splat/trail/trail.h"

#include <algorithm>
#include <array>
#include <memory>
#include <mutex>
#include <utility>

#include "base/grid.h"
#include "splat/tile/tile.h"
#include "splat/trail/trail_memory.h"

namespace bccsplat {
namespace {

// Returns whether the rays run inside both domains alike.
bool same_domain(const SplatScene& a, const SplatScene& b) {
  return a.view == b.view && a.slice->domain_begin == b.slice->domain_begin &&
         a.slice->domain_end == b.slice->domain_end && a.slice->clip.empty() && b.slice->clip.empty();
}

// Everything planned for tiles of one size.
struct Planned {
  std::vector<TrailObject> objects; // as listed
  DrawStats stats;
};

// A scene and what it is planned by.
struct Listed {
  const SplatScene* scene;
  const SplatOptions* options;
};

// `copies` is as make_plan's.
Planned plan_objects(std::span<const Listed> list, const Context& context, MemoryBudget* copies) {
  Planned planned;
  planned.objects.resize(list.size());
  const bool alike = std::all_of(list.begin(), list.end(),
                                 [&](const Listed& l) { return same_domain(*l.scene, *list.front().scene); });
  std::vector<DrawStats> stats(list.size());
  context.tasks.parallel_for(stats.size(), [&](uint64_t n) {
    const auto& [scene, options] = list[n];
    planned.objects[n] = {scene, make_plan(*scene, *options, context, stats[n], copies),
                          kernel_polynomial(scene->slice->kernel.space, options->kernel_form), !alike};
  });
  for (const DrawStats& s : stats) planned.stats += s;
  return planned;
}

// Lays a finished picture over another, in place.
TilePixels lay_over(const TilePixels& front, const TilePixels& back, TrailMemory& memory) {
  float* const base = memory.pixels.data(); // of `back`
  const auto writable = [&](const float* plane) { return plane ? base + (plane - base) : nullptr; };
  float *const red = writable(back.red), *const green = writable(back.green),
               *const blue = writable(back.blue);
  float *const alpha = writable(back.alpha), *const depth = writable(back.depth);
  for (int y = 0; y < back.height; ++y)
    for (int x = 0; x < back.width; ++x) {
      const auto p = plane_index(x, y, back.pitch);
      const auto f = plane_index(x, y, front.pitch);
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

// Returns whether as many of the largest tiles as there are threads find room.
template<class Bytes> bool fits_all_threads(size_t tiles, const Bytes& bytes, const Context& context) {
  uint64_t largest = 0;
  for (size_t n = 0; n < tiles; ++n) largest = std::max(largest, bytes(n));
  const uint64_t threads = context.tasks.threads();
  return largest <= (context.memory.limit() - context.memory.used()) / threads;
}

// Draws tiles by all threads: draw(n, memory, stats) with the memory that bytes(n) asks for.
template<class Bytes, class Draw>
DrawStats draw_tiles(size_t tiles, const Bytes& bytes, const Context& context, const Draw& draw) {
  DrawStats stats;
  std::mutex mutex;
  TrailMemoryPool pool(context.memory);
  struct Loan {
    TrailMemoryPool& pool;
    std::unique_ptr<TrailMemoryPool::Held> held;
    ~Loan() { pool.give_back(std::move(held)); }
  };
  uint64_t done = 0;
  context.tasks.parallel_for(tiles, [&](uint64_t n) {
    const Loan loan{pool, pool.take(bytes(n))};
    DrawStats mine;
    draw(n, loan.held->memory, mine);
    double fraction;
    {
      const std::scoped_lock lock(mutex);
      stats += mine;
      fraction = static_cast<double>(++done) / static_cast<double>(tiles);
    }
    context.progress.report(fraction);
  });
  return stats;
}

} // namespace

DrawStats splat_with_trail(const SplatObject& object, const SplatOptions& options, const Context& context,
                           const std::function<void(const TilePixels&)>& emit) {
  const SplatScene& slice = object.scene;
  const bool post = object.combine == TrailCombine::post;
  const bool apart = post || options.mode == RenderMode::isosurface;
  SplatOptions together = options;
  together.mode = RenderMode::composite;
  SplatOptions alone = apart ? options : together;
  if (apart) { // what is drawn apart goes into the trail's picture
    alone.with_deep = false;
    alone.preintegrate = post && options.mode == RenderMode::composite && !slice.table->integrals.empty();
  }

  std::vector<Listed> list{{&slice, &alone}};
  for (const SplatScene& source : object.sources) list.push_back({&source, &together});
  Planned planned;
  TrailJob job;
  job.stills = object.stills;
  job.combine = post ? TrailCombine::physical : object.combine;
  job.options = &together, job.context = &context, job.main = &slice;
  const auto plan = [&](int tile_size, MemoryBudget* copies) {
    // All objects share one grid of tiles.
    together.tile_size = alone.tile_size = options.tile_size > 0 ? options.tile_size : tile_size;
    planned = plan_objects(list, context, copies);
    job.slice = apart ? nullptr : &planned.objects[0];
    job.sources = std::span(planned.objects).subspan(1);
  };
  const auto bytes = [&](uint64_t n) { return tile_bytes(job, apart ? &planned.objects[0] : nullptr, n); };
  plan(large_trail_tile, &context.memory);
  if (!fits_all_threads(planned.objects[0].plan.tiles.size(), bytes, context))
    plan(small_trail_tile, nullptr);
  DrawStats stats = planned.stats;
  const std::vector<PlannedTile>& tiles = planned.objects[0].plan.tiles;
  const TileJob alone_job{&slice, &alone, &planned.objects[0].plan, &planned.objects[0].kernel, &context};
  // Labels, which only sheets side by side are classified by, as a field by itself.
  const SheetShare whole{0, 1};
  const std::array<TrailStill, 1> still{
      {{std::span(&whole, 1), slice.table, 1, slice.slice->frame, {}, true, 1}}};
  TrailJob labels = job;
  labels.sources = std::span(planned.objects).first(1), labels.stills = still, labels.options = &alone;
  const auto draw_front = [&](uint64_t n, TrailMemory& memory, DrawStats& mine) {
    if (!slice.slice->labels || alone.mode != RenderMode::composite)
      return draw_tile(alone_job, tiles[n], memory.slice, mine);
    const TilePixels front = draw_trail_tile(labels, n, tiles[n], nullptr, memory, mine);
    std::swap(memory.pixels, memory.front); // the trail has pixels of its own
    return front;
  };
  stats += draw_tiles(tiles.size(), bytes, context, [&](uint64_t n, TrailMemory& memory, DrawStats& mine) {
    if (!apart) return emit(draw_trail_tile(job, n, tiles[n], nullptr, memory, mine));
    const TilePixels front = draw_front(n, memory, mine);
    const TilePixels trail = draw_trail_tile(job, n, tiles[n], post ? nullptr : &front, memory, mine);
    emit(post ? lay_over(front, trail, memory) : trail);
  });
  return stats;
}

namespace {

// What all objects of a picture are drawn from, listed as one job.
struct TogetherList {
  std::vector<Listed> list;
  std::vector<SheetShare> alone; // of what is a field by itself
  std::vector<TrailStill> stills;
  std::vector<std::vector<SheetShare>> shares; // of the trails' stills
  std::vector<TrailCombine> pairs;

  TogetherList(std::span<const SplatObject> objects, const SplatOptions& options) {
    alone.reserve(objects.size());
    for (const SplatObject& o : objects) add(o, options);
    for (size_t n = 0, still = 0; n < objects.size(); still += 1 + objects[n].stills.size(), ++n) {
      if (!objects[n].scene.paint) continue;
      stills[still].paint = static_cast<uint32_t>(list.size());
      list.push_back({objects[n].scene.paint, &options});
    }
  }

 private:
  // Extinctions of slice and trail add like those of all others, or they are a pair.
  void add(const SplatObject& o, const SplatOptions& options) {
    const bool pair = !o.stills.empty() && o.combine != TrailCombine::physical;
    const size_t group = pair ? joined_groups + 2 * pairs.size() : 1;
    if (pair) pairs.push_back(o.combine);
    alone.push_back({static_cast<uint32_t>(list.size()), 1});
    list.push_back({&o.scene, &options});
    stills.push_back({std::span(&alone.back(), 1), o.scene.table, 1, o.scene.slice->frame, {}, true, group});
    const uint32_t first = static_cast<uint32_t>(list.size());
    for (const SplatScene& source : o.sources) list.push_back({&source, &options});
    for (const TrailStill& s : o.stills) {
      std::vector<SheetShare> moved(s.shares.begin(), s.shares.end());
      for (SheetShare& share : moved) share.source += first;
      stills.push_back(s);
      stills.back().shares = shares.emplace_back(std::move(moved)); // stays where it is when the list grows
      stills.back().group = pair ? group + 1 : group;
    }
  }
};

} // namespace

DrawStats splat_together(std::span<const SplatObject> scenes, const SplatOptions& options,
                         const Context& context, const std::function<void(const TilePixels&)>& emit) {
  SplatOptions together = options;
  const TogetherList all(scenes, together);
  Planned planned;
  TrailJob job;
  job.stills = all.stills, job.combine = TrailCombine::physical, job.pairs = all.pairs;
  job.options = &together, job.context = &context, job.main = &scenes.front().scene;
  const auto plan = [&](int tile_size, MemoryBudget* copies) {
    together.tile_size = options.tile_size > 0 ? options.tile_size : tile_size;
    planned = plan_objects(all.list, context, copies);
    job.sources = planned.objects;
  };
  const auto bytes = [&](uint64_t n) { return tile_bytes(job, nullptr, n); };
  plan(large_trail_tile, &context.memory);
  if (!fits_all_threads(planned.objects[0].plan.tiles.size(), bytes, context))
    plan(small_trail_tile, nullptr);
  DrawStats stats = planned.stats;
  const std::vector<PlannedTile>& tiles = planned.objects[0].plan.tiles;
  stats += draw_tiles(tiles.size(), bytes, context, [&](uint64_t n, TrailMemory& memory, DrawStats& mine) {
    emit(draw_trail_tile(job, n, tiles[n], nullptr, memory, mine));
  });
  return stats;
}

} // namespace bccsplat
