// SPDX-License-Identifier: Apache-2.0
// Codes a slab of tiles: a few that stand for all tell how to code them, and what a reader gets is compared
// until the slab is as near to its samples as was asked for. The sites of a tile are collected whenever they
// are needed: those of a whole slab would be four bytes each.
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/memory_turns.h"
#include "base/pool.h"
#include "formats/bcc4/coding/codes.h"
#include "formats/bcc4/coding/scratch.h"
#include "formats/bcc4/coding/tile.h"
#include "formats/bcc4/encode/choose_tile.h"
#include "formats/bcc4/encode/encode_tile.h"
#include "formats/bcc4/encode/tile_as_read.h"
#include "formats/bcc4/wavelet/step_walk.h"
#include "formats/bcc4/write/chunk_sites.h"
#include "formats/bcc4/write/writer_state.h"

namespace bccsplat {
namespace {

constexpr uint64_t collecting_bytes = 8; // of a site: its code, and once more while air is kept
constexpr uint64_t coding_bytes = 20;    // codes, values and coefficients, lists of these

// A tile to be coded, and what it became.
struct TileWork {
  uint32_t slot = 0;
  EncodedTile coded;
  uint64_t sites = 0, kept = 0, clamped = 0;
};

// The layers of a slab.
struct SlabLayers {
  const StoredLattice& level;
  int32_t slab;
  std::span<const SampleLayer> layers;
  const SampleCoder& coder;
};

TilePlace place_of(const StoredLattice& level, int32_t slab, uint32_t slot, int32_t layers) {
  TilePlace place = tile_place(level, slab, slot_brick(slot_dims(level), slot, level.tile_edge));
  place.layers = layers;
  return place;
}

TileSites collect_tile(const SlabLayers& of, uint32_t slot, uint64_t& clamped) {
  const auto& [level, slab, layers, coder] = of;
  const TilePlace place = place_of(level, slab, slot, static_cast<int32_t>(layers.size()));
  TileSites sites{place, {}};
  // Air may lie between two codes where a range is spread over them: then only what is left out is air.
  const bool air_has_code = coder.decode(coder.codes().air) == 0;
  for (int i = 0; i < place.bricks(); ++i) {
    const Int3 brick = place.brick_at(i);
    const ChunkShape shape = chunk_shape(*place.lattice, place.first_layer, place.layers, brick);
    sites.bricks.push_back(collect_sites(shape, layers, brick, coder, clamped));
    if (air_has_code) keep_but_blocks_of_air(sites.bricks.back(), coder.codes().air);
  }
  return sites;
}

// What the tiles of a slab are coded with, found from a few that stand for all.
TileRule rule_for(const SlabLayers& of, std::span<const TileWork> tiles, double mean_square) {
  constexpr size_t most = 4;
  const size_t count = std::min(most, tiles.size());
  std::vector<TileBox> boxes;
  std::vector<std::vector<float>> values;
  for (size_t i = 0; i < count; ++i) {
    uint64_t clamped = 0;
    const uint32_t slot = tiles[(2 * i + 1) * tiles.size() / (2 * count)].slot;
    const TileSites sites = collect_tile(of, slot, clamped);
    auto of_cosets = tile_values(sites, of.coder.codes());
    for (size_t c = 0; c < of_cosets.size(); ++c) {
      if (of_cosets[c].empty()) continue;
      boxes.push_back(sites.place.boxes()[c]);
      values.push_back(std::move(of_cosets[c]));
    }
  }
  return find_tile_rule(boxes, std::move(values), mean_square);
}

// The tiles of which any layer keeps a site.
std::vector<TileWork> find_tiles(const SlabLayers& of, const Context& context) {
  std::vector<TileWork> tiles(slot_count(of.level));
  MemoryTurns turns(context.memory);
  context.tasks.parallel_for(tiles.size(), [&](uint64_t i) {
    context.progress.check();
    TileWork& tile = tiles[i];
    tile.slot = static_cast<uint32_t>(i);
    tile.sites = place_of(of.level, of.slab, tile.slot, static_cast<int32_t>(of.layers.size())).sites();
    turns.run_one_beside(tile.sites * collecting_bytes,
                         [&] { tile.kept = collect_tile(of, tile.slot, tile.clamped).kept(); });
  });
  std::erase_if(tiles, [](const TileWork& tile) { return tile.kept == 0; });
  return tiles;
}

std::vector<SampleLayer> empty_layers(const StoredLattice& level, int32_t slab, int32_t layers) {
  std::vector<SampleLayer> out;
  for (int32_t m = 0; m < layers; ++m)
    out.emplace_back(level.lattice.space, level.lattice.coset(slab * level.slab_layers + m));
  return out;
}

// Brings what a reader gets of a tile into the layers of its slab.
void place_bricks(const TilePlace& place, std::vector<SampleBrick>&& bricks, std::span<SampleLayer> out) {
  for (size_t i = 0; i < bricks.size(); ++i) {
    if (!bricks[i]) continue;
    const Int3 to = place.brick_at(static_cast<int>(i / out.size()));
    SampleLayer& layer = out[i % out.size()];
    layer.set(layer.slot(to[0], to[1], to[2]), std::move(bricks[i]));
  }
}

// What a reader gets of a slab that was coded just now.
std::vector<SampleLayer> layers_as_read(const SlabLayers& of, std::span<TileWork> tiles) {
  const auto layers = static_cast<int32_t>(of.layers.size());
  std::vector<SampleLayer> out = empty_layers(of.level, of.slab, layers);
  for (TileWork& tile : tiles)
    place_bricks(place_of(of.level, of.slab, tile.slot, layers), std::move(tile.coded.bricks), out);
  return out;
}

// Steps that make the error which is asked for: errors are about a power of steps, which two of them tell.
class StepSearch {
 public:
  // error: over what it may be; returns what the next step is of this one.
  double next(double step, double error, int round) {
    constexpr double aim = .997, usual_power = 1.45, least_power = .8, most_power = 2;
    // Errors of less than a code shrink faster than their steps.
    constexpr double below_codes = .7, most = 4;
    constexpr int usual_rounds = 5; // then what is asked for may be out of reach
    constexpr double sooner = .96;
    double power = usual_power;
    if (step_ > 0 && step != step_)
      power = std::clamp(std::log(error / error_) / std::log(step / step_), least_power, most_power);
    step_ = step, error_ = error;
    double by = std::min(std::pow(aim / error, 1 / power), most);
    if (step < 1) by = std::max(by, below_codes);
    return round < usual_rounds ? by : std::min(by, std::pow(sooner, round - usual_rounds + 1));
  }

  // Returns whether the error is what may be, without bytes for less: steps grow only so often, and no more
  // where the error does not.
  [[nodiscard]] bool is_near(double step, double error, int round) const {
    constexpr double nearly = .93, grown = 1.01;
    constexpr int rounds = 3;
    const bool grows = step < step_ || error > grown * error_;
    return error <= 1 && (error >= nearly || round >= rounds || !grows || step >= largest_step);
  }

 private:
  double step_ = 0, error_ = 0; // before
};

// Throws bound_not_met where the squares of all errors of a slab, in codes, are more than they may be.
void require_allowed(const SlabLayers& of, const ChannelInfo& channel, double squares, double allowed) {
  if (squares <= allowed) return;
  const double reached = channel.wavelet_error * std::sqrt(squares / allowed);
  fail(Code::bound_not_met, "channel '", channel.name, "', slab ", of.slab, ": samples stored in steps of ",
       of.coder.scale(), " are off by ", reached, " in the mean, ", channel.wavelet_error,
       " asked for; a narrower range of the values or more bits, a larger error, or samples that are stored ",
       "as they are would do");
}

double sites_of(const SlabLayers& of) {
  const StoredLattice& level = of.level;
  double sites = 0;
  for (size_t m = 0; m < of.layers.size(); ++m) {
    const int32_t layer = of.slab * level.slab_layers + static_cast<int32_t>(m);
    sites += static_cast<double>(level.lattice.space.sites(level.lattice.coset(layer)));
  }
  return sites;
}

} // namespace

Bcc4Writer::State::CodedTiles Bcc4Writer::State::code_tiles(int32_t slab, const ChannelLevel& at,
                                                            std::span<const SampleLayer> layers,
                                                            double rounded, const Context& context) const {
  constexpr double unseen = .002;
  // Where samples are whole codes an eighth of one as a step leaves none of them off, and errors of less than
  // a code shrink faster than their steps.
  constexpr float least_step = .125F;
  constexpr double least_error = .12;
  const SampleCoder& coder = index->coder(at);
  CodedTiles out{.slab = slab, .at = at, .chunks = {}, .read = {}};
  const SlabLayers of{info.level(at.level), slab, layers, coder};
  const ChannelInfo& channel = info.channels[at.channel];
  const double all = sites_of(of), allowed = std::pow(channel.wavelet_error / coder.scale(), 2) * all;
  // Clamped samples are counted as such.
  double spent = std::min(rounded / (coder.scale() * coder.scale()), all / 4);
  if (spent < unseen * allowed) spent = 0;
  require_allowed(of, channel, spent, allowed);
  std::vector<TileWork> tiles = find_tiles(of, context);
  if (tiles.empty()) {
    out.read = layers_as_read(of, tiles);
    return out;
  }
  // Air is exact, so that the samples may be off by more.
  double kept = 0;
  for (const TileWork& tile : tiles) out.clamped += tile.clamped, kept += static_cast<double>(tile.kept);
  const double left = allowed - spent;
  TileRule rule = rule_for(of, tiles, std::max(left / kept, least_error * least_error));
  double error = 0;
  Pool<TileRoom> rooms;
  MemoryTurns turns(context.memory);
  const auto code = [&](TileWork& tile) {
    uint64_t clamped = 0;
    const TileSites sites = collect_tile(of, tile.slot, clamped);
    auto room = rooms.take([] { return std::make_unique<TileRoom>(); });
    tile.coded = encode_tile(sites, coder, rule, options.level, channel.linear, *room);
    rooms.give_back(std::move(room));
  };
  const auto code_all = [&] {
    context.tasks.parallel_for(tiles.size(), [&](uint64_t i) {
      context.progress.check();
      turns.run_one_beside(tiles[i].sites * coding_bytes, [&] { code(tiles[i]); });
    });
    error = 0;
    for (const TileWork& tile : tiles) error += tile.coded.squared_error;
  };
  StepSearch search;
  float good = 0; // the coarsest step so far whose error may be
  for (int round = 1;; ++round) {
    code_all();
    if (error <= left) good = std::max(good, rule.steps.step);
    if (error == 0 || rule.steps.step <= least_step || search.is_near(rule.steps.step, error / left, round))
      break;
    const double by = search.next(rule.steps.step, error / left, round);
    rule.steps.step = std::clamp(rule.steps.step * static_cast<float>(by), least_step, largest_step);
  }
  if (good > rule.steps.step) {
    rule.steps.step = good;
    code_all();
  }
  require_allowed(of, channel, spent + error, allowed);
  out.read = layers_as_read(of, tiles);
  for (TileWork& tile : tiles) {
    tile.coded.chunk.entry.slot = tile.slot;
    out.chunks.push_back(std::move(tile.coded.chunk));
  }
  return out;
}

WrittenSlab Bcc4Writer::State::encode_tiles(int32_t slab, const ChannelLevel& at,
                                            std::span<const SampleLayer> layers, double rounded,
                                            const Context& context) {
  last_tiles = {}; // what nobody has asked for goes before others are made
  last_tiles = code_tiles(slab, at, layers, rounded, context);
  WrittenSlab written{.slab = slab, .at = at, .chunks = {}};
  written.clamped = last_tiles.clamped;
  for (const EncodedChunk& chunk : last_tiles.chunks) append_chunk(at, chunk, written);
  return written;
}

std::vector<SampleLayer> Bcc4Writer::State::read_reused(int32_t slab, const ChannelLevel& at, int32_t layers,
                                                        const Context& context) const {
  const WrittenSlab* const found = in_journal(slab, at, layers);
  if (!found && !in_earlier(slab, at, layers)) return {};
  const std::unique_ptr<ByteSource> unfinished = found ? options.journal->open_unfinished() : nullptr;
  const std::vector<Bcc4Chunk> chunks = found ? found->chunks : options.earlier->chunks(at, slab);
  const auto stored = [&](const Bcc4Chunk& chunk) {
    if (!found) return options.earlier->stored_bytes(chunk);
    std::vector<std::byte> bytes(chunk.stored());
    unfinished->read_at(chunk.offset, bytes);
    return bytes;
  };
  const StoredLattice& level = info.level(at.level);
  std::vector<SampleLayer> out = empty_layers(level, slab, layers);
  Pool<ChunkScratch> scratches;
  MemoryTurns turns(context.memory);
  context.tasks.parallel_for(chunks.size(), [&](uint64_t i) {
    context.progress.check();
    const TilePlace place = place_of(level, slab, chunks[i].slot, layers);
    turns.run_one_beside(place.decoding_bytes(), [&] {
      auto scratch = scratches.take([] { return std::make_unique<ChunkScratch>(); });
      // Each task sets the slots of its own bricks.
      place_bricks(place,
                   read_stored(place, index->coder(at), info.channels[at.channel].linear, chunks[i],
                               stored(chunks[i]), *scratch),
                   out);
      scratches.give_back(std::move(scratch));
    });
  });
  return out;
}

std::vector<SampleLayer> Bcc4Writer::State::as_read(int32_t slab, const ChannelLevel& at,
                                                    std::span<const SampleLayer> layers, double rounded,
                                                    const Context& context) {
  if (last_tiles.slab != slab || last_tiles.at != at || last_tiles.read.empty()) {
    last_tiles = {};
    // A file holds what was coded for it, maybe by another version.
    auto read = read_reused(slab, at, static_cast<int32_t>(layers.size()), context);
    if (!read.empty()) return read;
    last_tiles = code_tiles(slab, at, layers, rounded, context);
  }
  return std::exchange(last_tiles.read, {});
}

} // namespace bccsplat
