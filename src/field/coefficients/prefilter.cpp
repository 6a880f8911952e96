// SPDX-License-Identifier: Apache-2.0
// Finds the layers that stages depend on, and divides a region into tiles that threads take through all
// stages (tile_planes.h), large where memory and threads allow. Prefilters whose first stage has a pole are
// left to inverse.h.
#include "field/coefficients/prefilter.h"

#include <algorithm>
#include <atomic>
#include <memory>
#include <mutex>

#include "base/aligned.h"
#include "field/coefficients/inverse.h"
#include "field/coefficients/prefilter_steps.h"
#include "field/coefficients/stage_plan.h"
#include "field/coefficients/tile_planes.h"

namespace bccsplat {
namespace {

// Bricks of a tile along x, y and z. What is around a tile is made again in the tiles beside it, so that they
// are large: 6 MB of planes for the six layers of an instant. Where there are few for the threads, or memory
// is short, they are smaller.
constexpr Int3 most_tile_bricks{6, 2, 6}, least_tile_bricks{2, 1, 2};
constexpr uint64_t tiles_per_thread = 3;
constexpr uint64_t planes_part = 4; // of the memory that is left, at most, but for the least tiles

uint64_t tiles_in(const BrickBox& region, const Int3& tile) {
  uint64_t n = 1;
  for (size_t a = 0; a < 3; ++a) n *= std::max(0, region.end[a] - region.begin[a] + tile[a] - 1) / tile[a];
  return n;
}

// Returns how many of its tiles a region has under way at once.
uint64_t tiles_at_once(const BrickBox& region, const Int3& tile, int threads) {
  return std::min(tiles_in(region, tile), static_cast<uint64_t>(threads));
}

Int3 tile_bricks(const StagePlan& plan, const BrickBox& region, const Context& context) {
  const int threads = context.tasks.threads();
  const uint64_t room = (context.memory.limit() - context.memory.used()) / planes_part;
  const uint64_t wanted = threads > 1 ? tiles_per_thread * threads : 1;
  Int3 tile;
  for (size_t a = 0; a < 3; ++a)
    tile[a] = std::clamp(region.end[a] - region.begin[a], 1, most_tile_bricks[a]);
  for (const size_t axis : {size_t{2}, size_t{1}, size_t{0}})
    while (tile[axis] > least_tile_bricks[axis] &&
           (tiles_in(region, tile) < wanted ||
            TileSize(plan, tile).bytes() * tiles_at_once(region, tile, threads) > room))
      tile[axis] = (tile[axis] + 1) / 2;
  return tile;
}

// The tiles of a layer: boxes of bricks, of which each brick of the region that may hold coefficients is in
// one.
std::vector<BrickBox> tiles_of(const BrickBox& region, const NearBricks& near, const Int3& bricks) {
  std::vector<BrickBox> tiles;
  for (int z = region.begin[2]; z < region.end[2]; z += bricks[2])
    for (int y = region.begin[1]; y < region.end[1]; y += bricks[1])
      for (int x = region.begin[0]; x < region.end[0]; x += bricks[0]) {
        BrickBox tile{{x, y, z}, {}};
        for (size_t a = 0; a < 3; ++a) tile.end[a] = std::min(region.end[a], tile.begin[a] + bricks[a]);
        if (near.trim(tile)) tiles.push_back(tile);
      }
  return tiles;
}

// The part of a region in which some layer has bricks.
BrickBox inside(BrickBox box, std::span<const SampleLayer> layers) {
  for (size_t a = 0; a < 3; ++a) {
    box.begin[a] = std::max(0, box.begin[a]);
    int32_t most = 0;
    for (const SampleLayer& layer : layers) most = std::max(most, layer.brick_dims()[a]);
    box.end[a] = std::min(box.end[a], most);
  }
  return box;
}

// Lends each task planes to work in.
class PlaneStore {
 public:
  explicit PlaneStore(size_t floats) : floats_(floats) {}

  std::unique_ptr<AlignedArray<float>> take() {
    {
      const std::scoped_lock lock(mutex_);
      if (!free_.empty()) {
        auto last = std::move(free_.back());
        free_.pop_back();
        return last;
      }
    }
    auto made = std::make_unique<AlignedArray<float>>();
    made->reserve(floats_);
    std::fill_n(made->data(), floats_, 0.0f); // what is computed beside a tile is a number
    return made;
  }
  void give(std::unique_ptr<AlignedArray<float>> planes) {
    const std::scoped_lock lock(mutex_);
    free_.push_back(std::move(planes));
  }

 private:
  size_t floats_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<AlignedArray<float>>> free_;
};

} // namespace

int32_t Prefilter::reach() const {
  if (lattice_.is_static()) return lattice_.space.cosets() - 1;
  const int32_t period = lattice_.layer_period();
  std::vector<int32_t> reach(steps_.size() + 1);
  for (size_t s = steps_.size(); s-- > 0;) {
    const auto& [filter, source] = steps_[s];
    const int32_t cross = filter.cross != 0 && lattice_.space.bcc ? 1 : 0;
    const int32_t before = filter.temporal != 0 || filter.mixed != 0 ? filter.stride * period : cross;
    const int32_t samples = filter.source_temporal != 0 || filter.source_mixed != 0 ? period : 0;
    reach[s] = std::max(reach[s], reach[s + 1] + before);
    int32_t& of_samples = reach[source];
    of_samples = std::max(of_samples, reach[s + 1] + samples);
  }
  return reach.front();
}

std::vector<std::set<int32_t>> Prefilter::needed(std::span<const int32_t> layers) const {
  std::vector<std::set<int32_t>> needed(steps_.size() + 1);
  needed.back().insert(layers.begin(), layers.end());
  for (size_t s = steps_.size(); s > 0; --s) {
    const auto& [filter, source] = steps_[s - 1];
    const auto reach = [&](size_t stage, int32_t distance) {
      for (const int32_t m : std::set<int32_t>(needed[s]))
        for (const int32_t d : {-distance, distance}) needed[stage].insert(lattice_.mirror_layer(m + d));
    };
    const size_t samples = source;
    reach(s - 1, 0);
    reach(samples, 0);
    if (filter.cross != 0 && lattice_.space.bcc) reach(s - 1, 1);
    if (filter.temporal != 0 || filter.mixed != 0) reach(s - 1, filter.stride * lattice_.layer_period());
    if (filter.source_temporal != 0 || filter.source_mixed != 0) reach(samples, lattice_.layer_period());
  }
  return needed;
}

InversePrefilter Prefilter::inverse() const {
  const std::vector<double> time = weights_in_time(std::span(steps_).subspan(1));
  return {steps_.front().filter, {time.begin(), time.end()}};
}

SampleLayer Prefilter::apply_to(int32_t layer, BrickLayer samples, const CoefficientForm& form,
                                const BrickBox& region, const Context& context) const {
  if (steps_.front().filter.pole != 0)
    return inverse().apply_in_space(std::move(samples), form, region, context);
  const SampleLayer own(samples);
  return std::move(apply(std::span(&layer, 1), {{layer, &own}}, form, region, context).front());
}

std::vector<SampleLayer> Prefilter::invert(std::span<const int32_t> layers,
                                           const std::map<int32_t, const SampleLayer*>& samples,
                                           const CoefficientForm& form, const BrickBox& region,
                                           const Context& context) const {
  const InversePrefilter inverse = this->inverse();
  std::vector<SampleLayer> made;
  for (const int32_t m : layers) made.push_back(inverse.apply(m, lattice_, samples, form, region, context));
  return made;
}

std::vector<SampleLayer> Prefilter::apply(std::span<const int32_t> layers,
                                          const std::map<int32_t, const SampleLayer*>& samples,
                                          const CoefficientForm& form, const BrickBox& region,
                                          const Context& context) const {
  if (steps_.front().filter.pole != 0) return invert(layers, samples, form, region, context);
  std::vector<SampleLayer> made;
  std::vector<TileLayer> outputs;
  for (const int32_t m : layers) made.emplace_back(lattice_.space, lattice_.coset(m));
  const BrickBox box = inside(region, made);
  for (size_t i = 0; i < layers.size(); ++i) outputs.push_back({&made[i], samples.at(layers[i])});
  const StagePlan plan(*this, layers);
  const Int3 bricks = tile_bricks(plan, box, context);
  const std::vector<BrickBox> tiles = tiles_of(box, NearBricks(samples, box), bricks);
  const TileSize size(plan, bricks);
  const uint64_t at_once = tiles_at_once(box, bricks, context.tasks.threads());
  const Reservation planes_held(context.memory, size.bytes() * at_once, "planes of the prefilter");
  PlaneStore store(size.floats());
  std::atomic<uint64_t> done{0};
  context.tasks.parallel_for(tiles.size(), [&](uint64_t i) {
    context.progress.advance(done.fetch_add(1, std::memory_order_relaxed), tiles.size());
    auto planes = store.take();
    TilePlanes(plan, size, lattice_.space, tiles[i], planes->data())
        .make(samples, outputs, form, context.progress);
    store.give(std::move(planes));
  });
  return made;
}

} // namespace bccsplat
