// SPDX-License-Identifier: Apache-2.0
// Finds the chunks of a slab in the cache or has them decoded, in batches that the budget has room for, and
// takes from each the bricks of all layers that are asked for together. Near the lost chunks of a damaged
// file it makes holes.
#include <algorithm>
#include <atomic>
#include <memory>
#include <mutex>
#include <set>
#include <tuple>
#include <type_traits>
#include <utility>

#include "base/error.h"
#include "base/lru_cache.h"
#include "base/would_block.h"
#include "formats/bcc4/coding/chunk.h"
#include "formats/bcc4/coding/scratch.h"
#include "formats/bcc4/read/held_chunk.h"
#include "formats/bcc4/read/near_loss.h"
#include "formats/bcc4/read/reader.h"
#include "formats/bcc4/read/samples.h"
#include "formats/bcc4/read/unchanged_slabs.h"
#include "formats/bcc4/sample_step.h"
#include "kernel/cc_kernel.h"
#include "points/absent.h"

namespace bccsplat {
namespace {

constexpr size_t batch_chunks = 256; // decoded at once; fewer where the budget is short
constexpr size_t task_chunks = 16;   // of those that have begun, whose rest one task decodes; of tiles one
// Who plays asks for so many layers at a time, each of which follows the last one, and soon for those behind
// them.
constexpr size_t playing_layers = 2;

using ChunkKey = std::tuple<int, int32_t, uint32_t>; // channel, slab, slot

// Returns the bit of a layer within its slab.
uint32_t layer_bit(const StoredLattice& info, int32_t layer) {
  return uint32_t{1} << (layer % info.slab_layers);
}

// The bytes that a brick takes at most when it is read.
uint64_t brick_bytes(const ChannelInfo& channel, bool as_codes) {
  constexpr uint64_t overhead = 1400; // which sites are kept, where rows start, allocations
  if (!as_codes || is_float(channel.type)) return sizeof(Brick);
  return value_bytes(channel.type) * brick_sites + overhead;
}

// Bricks of samples, as they are held.
struct MakeSamples {
  const Bcc4Reader& reader;
  ChannelLevel at;
  RelativeTo to;
  SampleBrick operator()(const ChunkData& data, int layer) const {
    return reader.samples(at, data, layer, to);
  }
  SampleBrick operator()(const OpenTile& tile, int brick, int layer) const {
    return reader.samples(at, tile, brick, layer, to);
  }
};

} // namespace

struct Bcc4Samples::Cache {
  Cache(MemoryBudget& b, uint64_t bytes) : budget(b), chunks(bytes) {}
  MemoryBudget& budget;
  LruCache<ChunkKey, HeldChunk> chunks;
  std::atomic<uint64_t> decoded{0}, layers_decoded{0};

  // Lets go of layers that were handed over to be kept.
  void give(const ChunkKey& key, uint32_t layers) {
    const auto held = chunks.look(key);
    if (!held) return;
    auto left = held->without(layers);
    chunks.drop(key);
    if (left) keep(key, std::move(left));
  }

  // Drops the oldest chunks until the budget has so much left, or there are none.
  void make_room(uint64_t bytes) {
    while (budget.limit() - budget.used() < bytes && chunks.drop_oldest()) {
    }
  }

  // Keeps a chunk, dropping the oldest ones to make room in the budget; without room it is not kept.
  void keep(const ChunkKey& key, std::shared_ptr<const HeldChunk> chunk) {
    const uint64_t bytes = chunk->bytes();
    make_room(bytes);
    try {
      chunks.insert(key, std::move(chunk), bytes, Reservation(budget, bytes, "cache of chunks"));
    } catch (const Error& e) {
      if (e.code() != Code::memory_budget) throw;
    }
  }
};

Bcc4Samples::Bcc4Samples(std::shared_ptr<const Bcc4Reader> reader, MemoryBudget& budget, uint64_t cache_bytes,
                         RelativeTo to, int level)
    : reader_(std::move(reader)), cache_(std::make_unique<Cache>(budget, cache_bytes)), to_(to),
      level_(level) {
  if (level < 0 || level >= reader_->info().level_count()) fail(Code::not_found, "no level ", level);
}
Bcc4Samples::~Bcc4Samples() = default;

void Bcc4Samples::take_over(const Bcc4Samples& older, const UnchangedSlabs& unchanged) {
  if (to_ != older.to_) return;
  cache_->chunks.take_over(older.cache_->chunks, [&](const ChunkKey& key) {
    return unchanged.slab({std::get<0>(key), level_}, std::get<1>(key));
  });
}

const Lattice4& Bcc4Samples::lattice() const { return reader_->info().level(level_).lattice; }
int Bcc4Samples::channels() const { return static_cast<int>(reader_->info().channels.size()); }
float Bcc4Samples::air(int channel) const { return reader_->info().channels.at(channel).air; }
float Bcc4Samples::base(int channel) const {
  return to_ == RelativeTo::base ? reader_->base(channel) : air(channel);
}
double Bcc4Samples::sample_step(int channel) const {
  return bccsplat::sample_step(reader_->info().channels.at(channel));
}
const Bcc4Reader& Bcc4Samples::reader() const { return *reader_; }
uint64_t Bcc4Samples::chunks_decoded() const { return cache_->decoded.load(std::memory_order_relaxed); }
uint64_t Bcc4Samples::chunk_layers_decoded() const {
  return cache_->layers_decoded.load(std::memory_order_relaxed);
}

void Bcc4Samples::finish_chunks(const ChannelLevel& at, std::span<const size_t> places,
                                std::span<std::shared_ptr<const HeldChunk>> held, uint32_t layers,
                                const Context& context) const {
  const MakeSamples samples{*reader_, at, to_};
  const size_t of_task = reader_->info().tile_edge > 1 ? 1 : task_chunks;
  context.tasks.parallel_for((places.size() + of_task - 1) / of_task, [&](uint64_t task) {
    context.progress.check();
    ChunkScratch scratch;
    const size_t first = task * of_task;
    for (const size_t i : places.subspan(first, std::min(of_task, places.size() - first))) {
      if (held[i]->is_open_tile()) {
        held[i] = std::make_shared<const HeldChunk>(*held[i], layers, samples);
        continue;
      }
      const ChunkData all =
          held[i]->finished([&](const ChunkRest& rest, const std::optional<LayersBefore>& before) {
            const int known = before ? rest.layers : 0;
            cache_->layers_decoded.fetch_add(rest.shape.layers - known, std::memory_order_relaxed);
            return reader_->finish_chunk(rest, before, scratch);
          });
      held[i] = std::make_shared<const HeldChunk>(*held[i], all, samples);
    }
  });
}

// Hands over a chunk, or the bricks of a tile.
void Bcc4Samples::for_bricks(uint32_t slot, const HeldChunk& held, const ChunkBody& body) const {
  const Int3 first = reader_->brick_position(slot, level_);
  const int edge = reader_->info().tile_edge;
  if (const LinearTile* const tile = held.linear()) {
    for (int i = 0; i < tile->bricks(); ++i) // beyond the lattice a tile has none
      if (tile->keeps_any(i))
        body({first[0] + i % edge, first[1] + i / edge % edge, first[2] + i / edge / edge}, held);
    return;
  }
  if (held.tile().empty()) return body(first, held);
  for (int i = 0; const HeldChunk& brick : held.tile()) {
    const Int3 at{first[0] + i % edge, first[1] + i / edge % edge, first[2] + i / edge / edge};
    if (brick.filled()) body(at, brick);
    ++i;
  }
}

MemoryBudget& Bcc4Samples::budget() const { return cache_->budget; }

// A layer of a batch of chunks is in memory beyond the cache, so that a batch is small where the budget is
// short.
size_t Bcc4Samples::chunks_at_once() const {
  const uint64_t chunk_bytes = reader_->info().level(level_).slab_layers * bricks_of_chunk() * sizeof(Brick);
  const uint64_t room = cache_->budget.limit() - cache_->budget.used();
  return std::clamp<uint64_t>(room / (4 * chunk_bytes), 1, batch_chunks);
}

std::vector<std::shared_ptr<const Bcc4Samples::HeldChunk>>
Bcc4Samples::fetch_chunks(const ChannelLevel& at, int32_t slab, std::span<const Bcc4Chunk> chunks,
                          const SlabLayers& layers, const Context& context, Attempts& attempts) const {
  const MakeSamples samples{*reader_, at, to_};
  std::vector<std::shared_ptr<const HeldChunk>> held(chunks.size());
  std::vector<Bcc4Chunk> missing;
  std::vector<size_t> missing_at, begun_at;
  for (size_t i = 0; i < chunks.size(); ++i) {
    held[i] = cache_->chunks.find({at.channel, slab, chunks[i].slot});
    if (held[i] && held[i]->has(layers.bits)) continue;
    if (held[i] && held[i]->can_have(layers.bits)) {
      begun_at.push_back(i);
      continue;
    }
    held[i] = nullptr;
    missing.push_back(chunks[i]);
    missing_at.push_back(i);
  }
  if (reader_->info().tile_edge > 1 && !missing.empty())
    cache_->make_room(reader_->decoding_bytes(at, missing.front()));
  reader_->read_chunks(at, missing, context, attempts, layers.end(), [&](size_t i, ChunkData&& data) {
    held[missing_at[i]] = std::make_shared<const HeldChunk>(
        std::make_shared<const ChunkData>(std::move(data)), samples, layers.bits);
  });
  finish_chunks(at, begun_at, held, layers.bits, context);
  const auto keep = [&](size_t i) {
    const ChunkKey key{at.channel, slab, chunks[i].slot};
    cache_->chunks.drop(key); // what was left of it
    cache_->keep(key, held[i]);
  };
  for (const size_t i : missing_at) {
    if (!held[i]) continue; // it is not there yet
    cache_->decoded.fetch_add(1, std::memory_order_relaxed);
    cache_->layers_decoded.fetch_add(held[i]->decoded(), std::memory_order_relaxed);
    keep(i);
  }
  for (const size_t i : begun_at) keep(i);
  return held;
}

void Bcc4Samples::for_chunks(int channel, int32_t slab, const BrickBox& region, const SlabLayers& layers,
                             const Context& context, const ChunkBody& body) const {
  const ChannelLevel at{channel, level_};
  const std::vector<Bcc4Chunk> wanted = reader_->chunks(at, slab, region);
  const size_t at_once = chunks_at_once();
  Attempts attempts;
  for (size_t first = 0; first < wanted.size(); first += at_once) {
    const auto batch = std::span(wanted).subspan(first, std::min(at_once, wanted.size() - first));
    const auto held = fetch_chunks(at, slab, batch, layers, context, attempts);
    if (!attempts.waits())
      context.tasks.parallel_for(batch.size(),
                                 [&](uint64_t i) { for_bricks(batch[i].slot, *held[i], body); });
  }
  attempts.throw_if_waiting();
}

uint64_t Bcc4Samples::bricks_of_chunk() const {
  const uint64_t edge = reader_->info().tile_edge;
  return edge * edge * edge;
}

std::set<int32_t> Bcc4Samples::slabs_beside(int32_t layer) const {
  const StoredLattice& info = reader_->info().level(level_);
  const Lattice4& l = info.lattice;
  const int reach = NearLoss(shown_kernel(), l).layers();
  std::set<int32_t> slabs;
  for (int32_t m = layer - reach; m <= layer + reach; ++m)
    if (l.periodic || (m >= 0 && m <= l.last_layer)) slabs.insert(info.slab_of(l.mirror_layer(m)));
  return slabs;
}

// What the field is made with: the recommended kernel, if it is known here and this lattice takes it.
std::string Bcc4Samples::shown_kernel() const {
  const std::string& name = reader_->info().recommended_kernel;
  try {
    return lattice().space.bcc ? make_kernel(name).name : make_cc_kernel(name).kernel.name;
  } catch (const Error&) {
    return {};
  }
}

// Where a chunk is lost, the field misses it as far as the kernel reaches: what lies there is lost as well.
void Bcc4Samples::lose_neighbours(int channel, int32_t layer, const BrickBox& region, const Context& context,
                                  BrickLayer& out) const {
  const NearLoss near(shown_kernel(), lattice());
  std::mutex mutex;
  std::vector<Int3> lost;
  for (const int32_t slab : slabs_beside(layer))
    for_chunks(channel, slab, go_round(region.widened(), lattice().space), {}, context,
               [&](const Int3& brick, const HeldChunk& held) {
                 if (!held.lost()) return;
                 const std::scoped_lock lock(mutex);
                 lost.push_back(brick);
               });
  near.mark(lost, out);
}

void Bcc4Samples::list_reads(int channel, int32_t layer, const BrickBox& region, bool missing,
                             std::vector<ByteRange>& out) const {
  const ChannelLevel at{channel, level_};
  const StoredLattice& info = reader_->info().level(level_);
  const auto list = [&](int32_t slab, const BrickBox& box, uint32_t layers) {
    if (!missing)
      for (const ByteRange& page : reader_->index_pages(at, slab)) out.push_back(page);
    for (const Bcc4Chunk& c : reader_->chunks(at, slab, box)) {
      const auto held = missing ? cache_->chunks.look({channel, slab, c.slot}) : nullptr;
      if (!held || !held->can_have(layers)) out.push_back({c.offset, c.stored()});
    }
  };
  list(info.slab_of(layer), region, layer_bit(info, layer));
  if (!reader_->salvages()) return;
  for (const int32_t slab : slabs_beside(layer)) list(slab, go_round(region.widened(), lattice().space), 0);
}

std::vector<Reservation> Bcc4Samples::reserve_others(const ChannelLevel& at, std::span<const int32_t> layers,
                                                     const BrickBox& region, uint64_t bytes_of_brick) const {
  const auto chunks = reader_->chunks(at, reader_->info().level(level_).slab_of(layers.front()), region);
  const uint64_t bytes = chunks.size() * bricks_of_chunk() * bytes_of_brick;
  uint64_t decoding = 0;
  if (reader_->info().tile_edge > 1)
    for (const Bcc4Chunk& c : chunks) decoding = std::max(decoding, reader_->decoding_bytes(at, c));
  std::vector<Reservation> held;
  while (held.size() + 1 < layers.size() && budget().try_reserve(bytes)) {
    held.push_back(Reservation::adopt(budget(), bytes));
    if (budget().limit() - budget().used() >= decoding) continue;
    held.pop_back();
    break;
  }
  return held;
}

template<class Layer, class MakeBrick>
void Bcc4Samples::read_slabs(int channel, std::span<const int32_t> layers, const BrickBox& region,
                             const Context& context, const TakeLayer<Layer>& take,
                             const MakeBrick& brick) const {
  const StoredLattice& info = reader_->info().level(level_);
  for (const int32_t m : layers)
    if (m < 0 || m >= info.lattice.layers()) fail(Code::out_of_domain, "no layer ", m);
  Attempts attempts;
  for (size_t first = 0, end = 0; first < layers.size(); first = end) {
    const int32_t slab = info.slab_of(layers[first]);
    while (end < layers.size() && info.slab_of(layers[end]) == slab) ++end;
    // Codes take no more than values.
    constexpr bool as_codes = std::is_same_v<Layer, SampleLayer>;
    std::vector<Reservation> held;
    if (!attempts.attempt([&] {
          held = reserve_others({channel, level_}, layers.subspan(first, end - first), region,
                                brick_bytes(reader_->info().channels.at(channel), as_codes));
        }))
      continue;
    end = first + held.size() + 1;
    std::vector<Layer> read;
    for (size_t i = first; i < end; ++i) read.emplace_back(info.lattice.space, info.lattice.coset(layers[i]));
    SlabLayers now{.bits = 0, .stops = layers.size() > playing_layers};
    for (size_t i = first; i < end; ++i) now.bits |= layer_bit(info, layers[i]);
    attempts.attempt([&] {
      // Each task sets the slots of its own bricks.
      for_chunks(channel, slab, region, now, context, [&](const Int3& b, const HeldChunk& data) {
        for (size_t i = 0; i < read.size(); ++i)
          if (auto made = brick(data, layers[first + i] % info.slab_layers))
            read[i].set(read[i].slot(b[0], b[1], b[2]), std::move(made));
      });
      if (as_codes && !attempts.waits()) // before those who take them reserve them
        for (const Bcc4Chunk& chunk : reader_->chunks({channel, level_}, slab, region))
          cache_->give({channel, slab, chunk.slot}, now.bits);
      for (size_t i = 0; i < read.size(); ++i) {
        if (!held.empty()) held.pop_back(); // whoever takes it reserves it
        take(layers[first + i], std::move(read[i]));
      }
    });
  }
  attempts.throw_if_waiting();
}

void Bcc4Samples::read_layers(int channel, std::span<const int32_t> layers, const BrickBox& region,
                              const Context& context, const TakeLayer<BrickLayer>& take) const {
  if (adds_layers(channel)) return read_linear(channel, layers, region, context, take);
  const bool lossy = reader_->salvages();
  const float absent = to_ == RelativeTo::base ? reader_->absent(channel) : 0;
  const TakeLayer<BrickLayer> mend = [&](int32_t m, BrickLayer&& layer) {
    if (lossy) lose_neighbours(channel, m, region, context, layer);
    if (absent != 0) fill_absent(layer, region, absent);
    take(m, std::move(layer));
  };
  read_slabs(channel, layers, region, context, lossy || absent != 0 ? mend : take,
             [&](const HeldChunk& held, int m) {
               const ChunkData* const data = held.data();
               return data ? reader_->brick({channel, level_}, *data, m, to_) : held.brick(m).as_values();
             });
}

void Bcc4Samples::read_samples(int channel, std::span<const int32_t> layers, const BrickBox& region,
                               const Context& context, const TakeLayer<SampleLayer>& take) const {
  // Damage takes more than its bricks, and sites that are not stored have no codes.
  if (reader_->salvages() || adds_layers(channel) ||
      (to_ == RelativeTo::base && reader_->absent(channel) != 0))
    return SampleSource::read_samples(channel, layers, region, context, take);
  read_slabs(channel, layers, region, context, take, [&](const HeldChunk& held, int m) {
    const ChunkData* const data = held.data();
    return data ? reader_->samples({channel, level_}, *data, m, to_) : held.brick(m);
  });
}

BrickLayer Bcc4Samples::read_layer(int channel, int32_t layer, const BrickBox& region,
                                   const Context& context) const {
  BrickLayer out;
  read_layers(channel, std::span(&layer, 1), region, context,
              [&](int32_t, BrickLayer&& read) { out = std::move(read); });
  return out;
}

} // namespace bccsplat
