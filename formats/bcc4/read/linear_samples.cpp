// SPDX-License-Identifier: Apache-2.0
// Samples of linear tiles: layers, and sums of layers, tile by tile. The tiles of a slab that are worked on
// are held, so that all sums are made of chunks that were decoded once, whatever the cache.
#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <utility>

#include "base/error.h"
#include "base/pool.h"
#include "base/would_block.h"
#include "formats/bcc4/read/held_chunk.h"
#include "formats/bcc4/read/samples.h"
#include "formats/bcc4/read/tile_sums.h"
#include "points/absent.h"

namespace bccsplat {
namespace {

// Chunks are there by rising slot.
std::span<const Bcc4Chunk> chunks_between(std::span<const Bcc4Chunk> chunks, uint32_t first, uint32_t last) {
  const auto before = [&](uint32_t slot) {
    const auto at =
        std::partition_point(chunks.begin(), chunks.end(), [&](const Bcc4Chunk& c) { return c.slot < slot; });
    return static_cast<size_t>(at - chunks.begin());
  };
  return chunks.subspan(before(first), before(last + 1) - before(first));
}

float total_of(const LayerSum& sum) {
  float total = 0;
  for (const LayerSum::Term& term : sum.terms) total += term.weight;
  return total;
}

// The bricks of a tile that are asked for; x fastest.
std::vector<bool> wanted_bricks(const Int3& first, int edge, const BrickLayer& layer,
                                const BrickBox& region) {
  std::vector<bool> wanted;
  const Int3& n = layer.brick_dims();
  for (int z = first[2]; z < first[2] + edge; ++z)
    for (int y = first[1]; y < first[1] + edge; ++y)
      for (int x = first[0]; x < first[0] + edge; ++x)
        wanted.push_back(x < n[0] && y < n[1] && z < n[2] && region.contains({x, y, z}));
  return wanted;
}

void take_holes(const BrickMask& hole, Brick* brick) {
  if (brick && hole != BrickMask{}) brick->hole = std::make_unique<BrickMask>(hole);
}

} // namespace

// What sums ask of a slab.
struct Bcc4Samples::SlabTerms {
  int32_t slab = 0;
  std::vector<std::vector<float>> weights; // of its layers, by sum
  std::vector<Bcc4Chunk> chunks;
  std::map<uint32_t, std::shared_ptr<const HeldChunk>> held; // by slot, those that are worked on

  [[nodiscard]] const LinearTile* tile(uint32_t slot) const {
    const auto at = held.find(slot);
    return at == held.end() ? nullptr : at->second->linear();
  }
};

std::vector<Bcc4Samples::SlabTerms> Bcc4Samples::terms_of(std::span<const LayerSum> sums) const {
  const StoredLattice& info = reader_->info().level(level_);
  std::map<int32_t, SlabTerms> slabs;
  for (size_t i = 0; i < sums.size(); ++i)
    for (const auto& [layer, weight] : sums[i].terms) {
      if (layer < 0 || layer >= info.lattice.layers()) fail(Code::out_of_domain, "no layer ", layer);
      SlabTerms& s = slabs[info.slab_of(layer)];
      s.slab = info.slab_of(layer);
      s.weights.resize(sums.size(), std::vector<float>(info.layers_of(s.slab)));
      s.weights[i][layer % info.slab_layers] += weight;
    }
  std::vector<SlabTerms> out;
  for (auto& [slab, terms] : slabs) out.push_back(std::move(terms));
  return out;
}

// All sums at a place of a tile.
void Bcc4Samples::add_tiles(std::span<const SlabTerms> slabs, uint32_t slot, std::span<const LayerSum> sums,
                            const TileValues& values, const BrickBox& region, std::vector<float>& room,
                            std::span<BrickLayer> out) const {
  const StoredLattice& info = reader_->info().level(level_);
  const Int3 first = reader_->brick_position(slot, level_);
  const std::vector<bool> wanted = wanted_bricks(first, info.tile_edge, out.front(), region);
  for (size_t i = 0; i < sums.size(); ++i) {
    std::vector<WeighedTile> tiles;
    const LinearTile* own = nullptr;
    for (const SlabTerms& s : slabs) {
      const auto& weights = s.weights[i];
      if (s.slab == info.slab_of(sums[i].layer)) own = s.tile(slot);
      if (std::any_of(weights.begin(), weights.end(), [](float w) { return w != 0; }))
        tiles.push_back({s.tile(slot), weights});
    }
    const auto bricks = sum_tiles(tiles, values, wanted, room);
    for (size_t b = 0; b < bricks.size(); ++b) {
      if (!bricks[b]) continue;
      const int n = static_cast<int>(b), edge = info.tile_edge;
      if (own) take_holes(own->hole(n, sums[i].layer % info.slab_layers), bricks[b].get());
      out[i].set(out[i].slot(first[0] + n % edge, first[1] + n / edge % edge, first[2] + n / edge / edge),
                 bricks[b]);
    }
  }
}

bool Bcc4Samples::adds_layers(int channel) const { return reader_->info().channels.at(channel).linear; }

uint64_t Bcc4Samples::bricks_at_most(int channel, std::span<const int32_t> layers,
                                     const BrickBox& region) const {
  std::set<int32_t> slabs;
  for (const int32_t m : layers) slabs.insert(reader_->info().level(level_).slab_of(m));
  std::set<uint32_t> slots;
  for (const int32_t slab : slabs)
    for (const Bcc4Chunk& c : reader_->chunks({channel, level_}, slab, region)) slots.insert(c.slot);
  return slots.size() * bricks_of_chunk();
}

std::vector<BrickLayer> Bcc4Samples::add_layers(int channel, std::span<const LayerSum> sums,
                                                const BrickBox& region, const Context& context) const {
  const ChannelLevel at{channel, level_};
  const Lattice4& lattice = reader_->info().level(level_).lattice;
  std::vector<SlabTerms> slabs = terms_of(sums);
  std::set<uint32_t> places;
  Attempts attempts;
  for (SlabTerms& s : slabs) {
    attempts.attempt([&] { s.chunks = reader_->chunks(at, s.slab, region); });
    for (const Bcc4Chunk& c : s.chunks) places.insert(c.slot);
  }
  std::vector<BrickLayer> out;
  for (const LayerSum& sum : sums) out.emplace_back(lattice.space, lattice.coset(sum.layer));
  const TileValues values = reader_->tile_values(at, to_);
  const std::vector<uint32_t> slots(places.begin(), places.end());
  const size_t at_once = chunks_at_once();
  Pool<std::vector<float>> rooms;
  for (size_t first = 0; first < slots.size(); first += at_once) {
    const auto batch = std::span(slots).subspan(first, std::min(at_once, slots.size() - first));
    for (SlabTerms& s : slabs) {
      const auto chunks = chunks_between(s.chunks, batch.front(), batch.back());
      const auto held = fetch_chunks(at, s.slab, chunks, {}, context, attempts);
      s.held.clear();
      for (size_t i = 0; i < chunks.size(); ++i) s.held[chunks[i].slot] = held[i];
    }
    if (attempts.waits()) continue;
    context.tasks.parallel_for(batch.size(), [&](uint64_t n) {
      context.progress.check();
      auto room = rooms.take([] { return std::make_unique<std::vector<float>>(); });
      add_tiles(slabs, batch[n], sums, values, region, *room, out);
      rooms.give_back(std::move(room));
    });
  }
  attempts.throw_if_waiting();
  for (size_t i = 0; i < sums.size(); ++i) {
    if (reader_->salvages()) lose_neighbours(channel, sums[i].layer, region, context, out[i]);
    if (values.absent != 0) fill_absent(out[i], region, values.absent * total_of(sums[i]));
  }
  return out;
}

void Bcc4Samples::read_linear(int channel, std::span<const int32_t> layers, const BrickBox& region,
                              const Context& context, const TakeLayer<BrickLayer>& take) const {
  const StoredLattice& info = reader_->info().level(level_);
  Attempts attempts;
  for (size_t first = 0, end = 0; first < layers.size(); first = end) {
    while (end < layers.size() && info.slab_of(layers[end]) == info.slab_of(layers[first])) ++end;
    std::vector<Reservation> held;
    if (!attempts.attempt([&] {
          held = reserve_others({channel, level_}, layers.subspan(first, end - first), region, sizeof(Brick));
        }))
      continue;
    end = first + held.size() + 1;
    std::vector<LayerSum> each;
    for (size_t i = first; i < end; ++i) each.push_back({layers[i], {{layers[i], 1}}});
    attempts.attempt([&] {
      std::vector<BrickLayer> read = add_layers(channel, each, region, context);
      for (size_t i = 0; i < read.size(); ++i) {
        if (!held.empty()) held.pop_back(); // whoever takes it reserves it
        take(layers[first + i], std::move(read[i]));
      }
    });
  }
  attempts.throw_if_waiting();
}

} // namespace bccsplat
