// SPDX-License-Identifier: Apache-2.0
// Plans all objects on one grid of tiles, with tiles small enough for every thread to find memory for one,
// and has each tile drawn. A surface with a trail is drawn first and ends the trail's rays.
#include "splat/splat_together.h"

#include <algorithm>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "base/grid.h"
#include "splat/tile/tile_pool.h"

namespace bccsplat {
namespace {

// Pixels of a tile. Tiles of 80 took least time of 48, 64, 80 and 96, for larger ones draw fewer points twice
// (tests/bench/notes/trail.md); small ones are for short memory.
constexpr int large_tile = 80, small_tile = 32;

// Returns whether the rays run inside both domains alike.
bool same_domain(const SplatScene& a, const SplatScene& b) {
  return a.view == b.view && a.slice->domain_begin == b.slice->domain_begin &&
         a.slice->domain_end == b.slice->domain_end && a.slice->clip.empty() && b.slice->clip.empty();
}

// Everything planned for tiles of one size.
struct Planned {
  std::vector<TileObject> objects; // as listed
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
  TilePool pool(context.memory);
  struct Loan {
    TilePool& pool;
    std::unique_ptr<TilePool::Held> held;
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

// Has everything planned by plan(tile_size, copies), and its tiles drawn as draw_tiles() does.
template<class Plan, class Bytes, class Draw>
DrawStats draw_planned(const Planned& planned, const Plan& plan, const Bytes& bytes, const Context& context,
                       const Draw& draw) {
  plan(large_tile, &context.memory);
  if (!fits_all_threads(planned.objects.front().plan.tiles.size(), bytes, context)) plan(small_tile, nullptr);
  DrawStats stats = planned.stats;
  stats += draw_tiles(planned.objects.front().plan.tiles.size(), bytes, context, draw);
  return stats;
}

// What objects are drawn from: their scenes, and what is made of these.
struct ObjectList {
  std::vector<const SplatScene*> scenes;
  std::vector<SplatStill> stills;
  std::vector<std::vector<SheetShare>> shares; // of the stills; each stays where it is when the list grows

  // Adds the slice of an object, as a field by itself.
  void add_slice(const SplatObject& o, size_t group) {
    shares.push_back({{static_cast<uint32_t>(scenes.size()), 1}});
    scenes.push_back(&o.scene);
    stills.push_back({shares.back(), o.scene.table, 1, o.scene.slice->frame, {}, true, group});
  }
  void add_trail(const SplatObject& o, size_t group) {
    const auto first = static_cast<uint32_t>(scenes.size());
    for (const SplatScene& source : o.sources) scenes.push_back(&source);
    for (const SplatStill& s : o.stills) {
      shares.emplace_back(s.shares.begin(), s.shares.end());
      for (SheetShare& share : shares.back()) share.source += first;
      stills.push_back(s);
      stills.back().shares = shares.back(), stills.back().group = group;
    }
  }
};

} // namespace

DrawStats splat_with_trail(const SplatObject& object, const SplatOptions& options, const Context& context,
                           const std::function<void(const TilePixels&)>& emit) {
  const SplatScene& slice = object.scene;
  const bool apart = options.mode == RenderMode::isosurface;
  SplatOptions together = options;
  together.mode = RenderMode::composite;
  SplatOptions alone = options; // of the surface, which goes into the trail's picture
  alone.with_deep = alone.preintegrate = false;

  ObjectList all;
  if (!apart) all.add_slice(object, 0);
  all.add_trail(object, 1);
  std::vector<Listed> list; // the slice first
  if (apart) list.push_back({&slice, &alone});
  for (const SplatScene* scene : all.scenes) list.push_back({scene, &together});

  Planned planned;
  TileJob job{.objects = {},
              .stills = all.stills,
              .combine = object.combine,
              .options = &together,
              .context = &context,
              .main = &slice};
  TileJob front_job{.objects = {}, .options = &alone, .context = &context, .main = &slice};
  const auto plan = [&](int tile_size, MemoryBudget* copies) {
    // All objects share one grid of tiles.
    together.tile_size = alone.tile_size = options.tile_size > 0 ? options.tile_size : tile_size;
    planned = plan_objects(list, context, copies);
    job.objects = std::span(planned.objects).subspan(apart ? 1 : 0);
    front_job.objects = std::span(planned.objects).first(1);
  };
  const auto bytes = [&](uint64_t n) { return tile_bytes(job, n) + (apart ? tile_bytes(front_job, n) : 0); };
  return draw_planned(planned, plan, bytes, context, [&](uint64_t n, TileMemory& memory, DrawStats& mine) {
    if (!apart) return emit(draw_tile(job, n, nullptr, memory, mine));
    if (!memory.apart) memory.apart = std::make_unique<TileMemory>();
    const TilePixels before = draw_tile(front_job, n, nullptr, *memory.apart, mine);
    emit(draw_tile(job, n, &before, memory, mine));
  });
}

DrawStats splat_together(std::span<const SplatObject> objects, const SplatOptions& options,
                         const Context& context, const std::function<void(const TilePixels&)>& emit) {
  ObjectList all;
  std::vector<TrailCombine> pairs;
  std::vector<size_t> still_of; // each object's slice
  for (const SplatObject& o : objects) {
    // Extinctions of slice and trail add like those of all others, or they are a pair.
    const bool pair = !o.stills.empty() && o.combine != TrailCombine::physical;
    const size_t group = pair ? joined_groups + 2 * pairs.size() : 1;
    if (pair) pairs.push_back(o.combine);
    still_of.push_back(all.stills.size());
    all.add_slice(o, group);
    all.add_trail(o, pair ? group + 1 : group);
  }
  for (size_t n = 0; n < objects.size(); ++n)
    if (const SplatScene* const paint = objects[n].scene.paint) {
      all.stills[still_of[n]].paint = static_cast<uint32_t>(all.scenes.size());
      all.scenes.push_back(paint);
    }
  SplatOptions together = options;
  std::vector<Listed> list;
  for (const SplatScene* scene : all.scenes) list.push_back({scene, &together});
  Planned planned;
  TileJob job{.objects = {},
              .stills = all.stills,
              .pairs = pairs,
              .options = &together,
              .context = &context,
              .main = &objects.front().scene};
  const auto plan = [&](int tile_size, MemoryBudget* copies) {
    together.tile_size = options.tile_size > 0 ? options.tile_size : tile_size;
    planned = plan_objects(list, context, copies);
    job.objects = planned.objects;
  };
  const auto bytes = [&](uint64_t n) { return tile_bytes(job, n); };
  return draw_planned(planned, plan, bytes, context, [&](uint64_t n, TileMemory& memory, DrawStats& mine) {
    emit(draw_tile(job, n, nullptr, memory, mine));
  });
}

} // namespace bccsplat
