#include "splat/trail.h"

#include <algorithm>
#include <memory>
#include <mutex>

#include "splat/tile.h"

namespace bccsplat {
namespace {

// What one thread draws a tile in.
struct Memory {
  TileMemory slice, part;
  SheetStack stack;
  AlignedArray<float> pixels;
};

struct Object {
  SplatScene scene;
  SplatOptions options;
  SplatPlan plan;
  KernelPolynomial kernel;
  float weight;
};

Object plan_object(const SplatScene& scene, const SplatOptions& options, float weight, int threads,
                   SplatStats& stats) {
  Object o{scene, options, {}, kernel_polynomial(scene.slice->kernel.space), weight};
  o.plan = make_plan(scene, options, threads, stats);
  return o;
}

class TileBlend {
 public:
  TileBlend(const PlannedTile& tile, Memory& memory, const SplatOptions& options)
      : tile_(tile), memory_(memory), pitch_((tile.width + 15) / 16 * 16) {
    const auto count = static_cast<size_t>(pitch_) * static_cast<size_t>(tile.height);
    memory_.pixels.reserve(7 * count);
    float** const planes[] = {&out_.red,   &out_.green, &out_.blue, &out_.alpha,
                              &out_.depth, &out_.value, &out_.time};
    size_t n = 0;
    for (float** p : planes) *p = memory_.pixels.data() + n++ * count;
    if (!options.with_value) out_.value = nullptr;
    if (!options.with_time) out_.time = nullptr;
  }

  TilePixels composite(TrailCombine combine, const TilePixels* surface, float stop) {
    composite_stack(memory_.stack, combine, surface, stop, tile_.width, tile_.height, pitch_, out_);
    return {tile_.x,    tile_.y,   tile_.width, tile_.height, pitch_,     out_.red,
            out_.green, out_.blue, out_.alpha,  out_.depth,   out_.value, out_.time};
  }

  // Puts a finished picture over what composite() made.
  TilePixels over(const TilePixels& front) {
    for (int y = 0; y < tile_.height; ++y)
      for (int x = 0; x < tile_.width; ++x) {
        const auto p = static_cast<size_t>(y) * static_cast<size_t>(pitch_) + static_cast<size_t>(x);
        const auto f = static_cast<size_t>(y) * static_cast<size_t>(front.pitch) + static_cast<size_t>(x);
        const float a = front.alpha[f], b = (1 - a) * out_.alpha[p], sum = a + b;
        const auto mean = [&](float* back, const float* of) { // NaN where a picture has nothing
          if (!back) return;
          back[p] = sum > 0 ? ((a > 0 ? a * of[f] : 0) + (b > 0 ? b * back[p] : 0)) / sum : of[f];
        };
        mean(out_.value, front.value), mean(out_.time, front.time);
        const auto blend = [&](float* back, const float* of) { back[p] = of[f] + (1 - a) * back[p]; };
        blend(out_.red, front.red), blend(out_.green, front.green), blend(out_.blue, front.blue);
        out_.alpha[p] = sum;
        out_.depth[p] = std::min(out_.depth[p], front.depth[f]);
      }
    return {tile_.x,    tile_.y,   tile_.width, tile_.height, pitch_,     out_.red,
            out_.green, out_.blue, out_.alpha,  out_.depth,   out_.value, out_.time};
  }

 private:
  const PlannedTile& tile_;
  Memory& memory_;
  int pitch_;
  PixelPlanes out_;
};

} // namespace

SplatStats splat_with_trail(const SplatScene& slice, std::span<const TrailPart> trail, TrailCombine combine,
                            const SplatOptions& options, const Context& context,
                            const std::function<void(const TilePixels&)>& emit) {
  // One grid of tiles for all objects; what an object hides of itself must not be skipped where another one
  // shines through.
  SplatOptions shared = options;
  if (shared.tile_size == 0) shared.tile_size = 32;
  SplatOptions stacked = shared;
  stacked.mode = RenderMode::composite;
  stacked.disable_skips |= skip_occlusion;
  stacked.with_value = stacked.with_time = true; // the stack decides what is kept

  SplatStats stats;
  const int threads = context.tasks.threads();
  const bool apart = options.mode == RenderMode::isosurface || combine == TrailCombine::post;
  const Object still = plan_object(slice, apart ? shared : stacked, 1, threads, stats);
  std::vector<Object> parts;
  for (const TrailPart& t : trail) parts.push_back(plan_object(t.scene, stacked, t.weight, threads, stats));
  // Sheets of the whole stack: all slices share the view's.
  int64_t first = still.plan.first_sheet, last = still.plan.last_sheet;
  for (const Object& o : parts)
    first = std::min(first, o.plan.first_sheet), last = std::max(last, o.plan.last_sheet);
  stats.tiles = still.plan.tiles.size();

  std::mutex mutex;
  std::vector<std::unique_ptr<Memory>> idle;
  uint64_t done = 0;
  context.tasks.parallel_for(still.plan.tiles.size(), [&](uint64_t n) {
    std::unique_ptr<Memory> memory;
    {
      const std::scoped_lock lock(mutex);
      if (!idle.empty()) {
        memory = std::move(idle.back());
        idle.pop_back();
      }
    }
    if (!memory) memory = std::make_unique<Memory>();
    SplatStats mine;
    const PlannedTile& tile = still.plan.tiles[n];
    memory->stack.prepare(
        first, last, static_cast<size_t>((tile.width + 15) / 16 * 16) * static_cast<size_t>(tile.height));
    const auto draw = [&](const Object& o, TileMemory& in, SheetStack* stack, size_t group) {
      const TileJob job{&o.scene, &o.options, &o.plan, &o.kernel, &context, stack, group, o.weight};
      return draw_tile(job, o.plan.tiles[n], in, mine);
    };
    const TilePixels alone = draw(still, memory->slice, apart ? nullptr : &memory->stack, 0);
    for (const Object& o : parts) draw(o, memory->part, &memory->stack, 1);
    const float stop = options.opacity_stop < 1 ? static_cast<float>(options.opacity_stop) : 2.0f;
    TileBlend blend(tile, *memory, options);
    if (combine == TrailCombine::post) {
      (void)blend.composite(TrailCombine::physical, nullptr, stop);
      emit(blend.over(alone));
    } else {
      emit(blend.composite(combine, apart ? &alone : nullptr, stop));
    }
    double fraction;
    {
      const std::scoped_lock lock(mutex);
      idle.push_back(std::move(memory));
      add(stats, mine);
      fraction = static_cast<double>(++done) / static_cast<double>(still.plan.tiles.size());
    }
    context.progress.report(fraction);
  });
  return stats;
}

} // namespace bccsplat
