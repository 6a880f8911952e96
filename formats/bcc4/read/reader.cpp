// SPDX-License-Identifier: Apache-2.0
// Finds the chunks of a slab in the index of a file, reads and decodes them; when salvaging, what is damaged
// becomes holes.
#include <algorithm>
#include <climits>
#include <map>
#include <numeric>

#include "base/memory_turns.h"
#include "base/pool.h"
#include "base/would_block.h"
#include "formats/bcc4/coding/chunk_parts.h"
#include "formats/bcc4/coding/deflate.h"
#include "formats/bcc4/coding/layer_codes.h"
#include "formats/bcc4/coding/linear_tile.h"
#include "formats/bcc4/coding/open_tile.h"
#include "formats/bcc4/coding/scratch.h"
#include "formats/bcc4/field_base.h"
#include "formats/bcc4/file_limits.h"
#include "formats/bcc4/read/reader.h"
#include "formats/bcc4/read/reader_state.h"
#include "formats/bcc4/read/tile_sums.h"

namespace bccsplat {
namespace {

constexpr uint64_t group_bytes = 256 << 10; // of chunks that one task reads and decodes
// A read takes so many gaps at most, where reads cost so much that wide gaps are read with them.
constexpr uint64_t gaps_per_group = 16;
constexpr size_t most_lost = 1 << 20; // chunks that one damaged page may have listed

// The bytes of chunks that are read together.
struct StoredGroup {
  std::vector<std::byte> bytes;
  bool is_here = false, is_read = false; // not: waited for; lost
};

} // namespace

void Bcc4Reader::State::read(uint64_t offset, std::span<std::byte> out) const {
  source->read_at(offset, out);
  bytes_read.fetch_add(out.size(), std::memory_order_relaxed);
}

bool Bcc4Reader::State::read_or_lose(uint64_t offset, std::span<std::byte> out) const {
  try {
    read(offset, out);
    return true;
  } catch (const Error& e) {
    if (!goes_without(e)) throw;
    return false;
  }
}

std::vector<std::byte> Bcc4Reader::State::read_block(const BlockRef& ref, std::string_view what) const {
  std::vector<std::byte> stored(ref.padded());
  read(ref.offset, stored);
  return unpack_block(ref, stored, what);
}

void Bcc4Reader::take_over(const Bcc4Reader& older) const {
  std::map<uint64_t, size_t> places; // in the other directory, by offset
  for (size_t n = 0; n < older.state_->pages.size(); ++n) places[older.state_->pages[n].block.offset] = n;
  for (size_t n = 0; n < state_->pages.size(); ++n) {
    const auto place = places.find(state_->pages[n].block.offset);
    if (place == places.end() || !(older.state_->pages[place->second] == state_->pages[n])) continue;
    if (auto page = older.state_->cached.look(place->second)) state_->cached.insert(n, page, 1, 0);
  }
}

std::shared_ptr<const Page> Bcc4Reader::State::load_page(size_t index) const {
  const PageRef& ref = pages[index];
  return std::make_shared<const Page>(
      read_page(read_block(ref.block, "index page"), ref, info, root.file_bytes));
}

std::shared_ptr<const Page> Bcc4Reader::State::page(size_t index) const {
  if (auto found = cached.find(index)) return found;
  std::shared_ptr<const Page> loaded;
  try {
    loaded = in_file([&] { return load_page(index); });
  } catch (const Error& e) {
    if (!goes_without(e)) throw;
    loaded = std::make_shared<const Page>(lost_page(pages[index]));
  }
  // What a lost page may have listed is more than any page lists.
  cached.insert(index, loaded, 1 + loaded->size() / (max_page_entries + 1), 0);
  return loaded;
}

void Bcc4Reader::State::require(const ChannelLevel& at) const {
  if (at.channel < 0 || static_cast<size_t>(at.channel) >= info.channels.size())
    fail(Code::not_found, source->name(), ": no channel ", at.channel);
  if (at.level < 0 || at.level >= info.level_count())
    fail(Code::not_found, source->name(), ": no level ", at.level, ", the last one is ",
         info.level_count() - 1);
}

ChunkData Bcc4Reader::State::decode(const ChannelLevel& at, const Bcc4Chunk& chunk,
                                    std::span<const std::byte> stored, ChunkScratch& scratch,
                                    int layers) const {
  if (info.tile_edge > 1) {
    ChunkData data;
    data.coded = coder(at).codes();
    const TilePlace place = tile_of(chunk, at.level);
    if (info.channels[at.channel].linear)
      data.linear = std::make_shared<const LinearTile>(place, data.coded, chunk, stored, scratch);
    else
      data.tile = std::make_shared<const OpenTile>(place, data.coded, chunk, stored, scratch);
    return data;
  }
  return decode_chunk(shape_of(chunk, at.level), coder(at).codes(), chunk, stored, scratch, layers);
}

Page Bcc4Reader::State::lost_page(const PageRef& ref) const {
  const auto count = static_cast<uint32_t>(slot_count(info.level(ref.at().level)));
  Page page;
  for (int32_t slab = ref.first_slab; slab <= ref.last_slab; ++slab)
    for (uint32_t slot = slab == ref.first_slab ? ref.first_slot : 0;
         slot < count && (slab < ref.last_slab || slot <= ref.last_slot); ++slot) {
      if (page.size() == most_lost)
        fail(Code::limit_exceeded, "index page at offset ", ref.block.offset, ": more than ", most_lost,
             " chunks may be lost");
      Bcc4Chunk c;
      c.slab = slab, c.slot = slot;
      page.push_back(c);
    }
  return page;
}

ChunkData Bcc4Reader::State::lost_chunk(const ChannelLevel& at, const Bcc4Chunk& chunk) const {
  const ChunkCodes& codes = coder(at).codes();
  ChunkData data;
  if (info.channels[at.channel].linear)
    data.linear = std::make_shared<const LinearTile>(tile_of(chunk, at.level));
  else
    data = info.tile_edge > 1 ? tile_of_holes(tile_of(chunk, at.level), codes)
                              : chunk_of_holes(shape_of(chunk, at.level), codes);
  data.lost = true;
  return data;
}

ChunkData Bcc4Reader::State::decode_or_lose(const ChannelLevel& at, const Bcc4Chunk& chunk,
                                            std::span<const std::byte> stored, ChunkScratch& scratch,
                                            int layers) const {
  if (!limits.salvage) return in_file([&] { return decode(at, chunk, stored, scratch, layers); });
  // Whole, so that no damage shows after a part of it was handed over.
  try {
    if (chunk.kept > 0 && stored.size() == chunk.stored()) return decode(at, chunk, stored, scratch);
  } catch (const Error& e) {
    if (!goes_without(e)) throw;
  }
  return lost_chunk(at, chunk);
}

std::vector<ChunkGroup> group_chunks(std::span<const Bcc4Chunk> chunks, uint64_t gap) {
  // The gaps of hosts may be of any size.
  const uint64_t most = std::max(group_bytes, std::min(gap, UINT64_MAX / gaps_per_group) * gaps_per_group);
  std::vector<size_t> order(chunks.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::sort(order.begin(), order.end(),
            [&](size_t a, size_t b) { return chunks[a].offset < chunks[b].offset; });
  std::vector<ChunkGroup> groups;
  for (const size_t i : order) {
    const Bcc4Chunk& c = chunks[i];
    const uint64_t end = c.offset + c.stored();
    ChunkGroup* g = groups.empty() ? nullptr : &groups.back();
    const uint64_t reached = g ? g->offset + g->bytes : 0;
    if (!g || (c.offset > reached && c.offset - reached > gap) || end - g->offset > most)
      g = &groups.emplace_back(ChunkGroup{c.offset, 0, {}});
    g->bytes = std::max(g->bytes, end - g->offset);
    g->members.push_back(i);
  }
  return groups;
}

Bcc4Reader::Bcc4Reader(std::unique_ptr<State> state) : state_(std::move(state)) {}
Bcc4Reader::~Bcc4Reader() = default;

const VolumeInfo& Bcc4Reader::info() const { return state_->shown ? *state_->shown : state_->info; }
const Bcc4Bytes& Bcc4Reader::bytes() const { return state_->bytes; }
uint64_t Bcc4Reader::chunk_count() const { return state_->root.chunks; }
uint64_t Bcc4Reader::bytes_read() const { return state_->bytes_read.load(std::memory_order_relaxed); }
uint64_t Bcc4Reader::merge_gap() const { return state_->source->merge_gap(); }
bool Bcc4Reader::salvages() const { return state_->limits.salvage; }
bool Bcc4Reader::goes_without(const Error& failure) const { return state_->goes_without(failure); }
bool Bcc4Reader::root_damaged() const { return state_->root_damaged; }
Int3 Bcc4Reader::brick_position(uint32_t slot, int level) const { return state_->brick_of(slot, level); }

std::pair<size_t, size_t> Bcc4Reader::State::pages_of(const ChannelLevel& at, int32_t slab) const {
  const auto key = std::pair(at, slab);
  const auto begin = std::partition_point(
      pages.begin(), pages.end(), [&](const PageRef& p) { return std::pair(p.at(), p.last_slab) < key; });
  const auto end = std::partition_point(
      begin, pages.end(), [&](const PageRef& p) { return std::pair(p.at(), p.first_slab) <= key; });
  return {begin - pages.begin(), end - pages.begin()};
}

std::vector<ByteRange> Bcc4Reader::index_pages(const ChannelLevel& at, int32_t slab) const {
  state_->require(at);
  std::vector<ByteRange> ranges;
  const auto [begin, end] = state_->pages_of(at, slab);
  for (size_t p = begin; p < end; ++p)
    ranges.push_back({state_->pages[p].block.offset, state_->pages[p].block.padded()});
  return ranges;
}

std::vector<Bcc4Chunk> Bcc4Reader::chunks(const ChannelLevel& at, int32_t slab,
                                          const BrickBox& region) const {
  const State& s = *state_;
  s.require(at);
  if (slab < 0 || slab >= s.info.level(at.level).slabs())
    fail(Code::out_of_domain, s.source->name(), ": no slab ", slab);
  std::vector<Bcc4Chunk> found;
  Attempts attempts;
  const auto [begin, end] = s.pages_of(at, slab);
  for (size_t p = begin; p < end; ++p)
    attempts.attempt([&] {
      const auto entries = s.page(p);
      auto c = std::partition_point(entries->begin(), entries->end(),
                                    [&](const Bcc4Chunk& e) { return e.slab < slab; });
      for (; c != entries->end() && c->slab == slab; ++c)
        if (region.meets(s.brick_of(c->slot, at.level), s.info.tile_edge)) found.push_back(*c);
    });
  attempts.throw_if_waiting();
  return found;
}

uint64_t Bcc4Reader::decoding_bytes(const ChannelLevel& at, const Bcc4Chunk& tile) const {
  return state_->tile_of(tile, at.level).decoding_bytes();
}

uint64_t Bcc4Reader::level_bytes(int level) const {
  uint64_t bytes = 0;
  for (size_t p = 0; p < state_->pages.size(); ++p)
    if (state_->pages[p].at().level == level)
      for (const Bcc4Chunk& c : *state_->page(p)) bytes += c.stored();
  return bytes;
}

Range Bcc4Reader::sample_range(const ChannelLevel& at, const Bcc4Chunk& chunk) const {
  const SampleCoder& coder = state_->coder(at);
  return {coder.decode(chunk.min_code), coder.decode(chunk.max_code)};
}

void Bcc4Reader::try_read(const ByteRange& range) const {
  std::vector<std::byte> bytes(range.size);
  (void)state_->read_or_lose(range.offset, bytes);
}

std::vector<std::byte> Bcc4Reader::stored_bytes(const Bcc4Chunk& chunk) const {
  std::vector<std::byte> stored(chunk.stored());
  state_->read(chunk.offset, stored);
  if (crc32_of(stored) != chunk.crc)
    fail(Code::checksum_mismatch, "chunk at offset ", chunk.offset, ": bad checksum");
  return stored;
}

void Bcc4Reader::read_chunks(const ChannelLevel& at, std::span<const Bcc4Chunk> chunks,
                             const Context& context, Attempts& attempts, int layers,
                             const TakeChunk& take) const {
  const std::vector<ChunkGroup> groups = group_chunks(chunks, merge_gap());
  std::vector<StoredGroup> stored(groups.size());
  const auto decode = [&](size_t g, size_t i, ChunkScratch& scratch) {
    auto part = std::span<const std::byte>(stored[g].bytes);
    part = stored[g].is_read ? part.subspan(chunks[i].offset - groups[g].offset, chunks[i].stored())
                             : part.first(0);
    take(i, state_->decode_or_lose(at, chunks[i], part, scratch, layers));
  };
  const bool tiles = info().tile_edge > 1;
  context.tasks.parallel_for(groups.size(), [&](uint64_t g) {
    context.progress.check();
    StoredGroup& s = stored[g];
    s.bytes.resize(groups[g].bytes);
    s.is_here = attempts.attempt([&] { s.is_read = state_->read_or_lose(groups[g].offset, s.bytes); });
    if (!s.is_here || tiles) return;
    ChunkScratch scratch;
    for (const size_t i : groups[g].members) decode(g, i, scratch);
    s.bytes = {};
  });
  if (!tiles) return;
  // A tile takes as long as many chunks, so that each is a task.
  std::vector<std::pair<size_t, size_t>> later;
  for (size_t g = 0; g < groups.size(); ++g)
    for (const size_t i : groups[g].members)
      if (stored[g].is_here) later.emplace_back(g, i);
  MemoryTurns turns(context.memory);
  Pool<ChunkScratch> scratches;
  context.tasks.parallel_for(later.size(), [&](uint64_t n) {
    context.progress.check();
    const size_t g = later[n].first, i = later[n].second;
    turns.run(decoding_bytes(at, chunks[i]), "decoding a tile", [&] {
      auto scratch = scratches.take([] { return std::make_unique<ChunkScratch>(); });
      decode(g, i, *scratch);
      scratches.give_back(std::move(scratch));
    });
  });
}

std::vector<std::shared_ptr<const ChunkData>> Bcc4Reader::read_chunks(const ChannelLevel& at,
                                                                      std::span<const Bcc4Chunk> chunks,
                                                                      const Context& context) const {
  std::vector<std::shared_ptr<const ChunkData>> out(chunks.size());
  Attempts attempts;
  read_chunks(at, chunks, context, attempts, INT_MAX, [&](size_t i, ChunkData&& data) {
    out[i] = std::make_shared<const ChunkData>(data.tile ? whole_tile(*data.tile) : std::move(data));
  });
  attempts.throw_if_waiting();
  return out;
}

ChunkData Bcc4Reader::finish_chunk(const ChunkRest& rest,
                                   const std::optional<std::array<std::span<const std::byte>, 2>>& before,
                                   ChunkScratch& scratch) const {
  return state_->in_file([&] { return bccsplat::finish_chunk(rest, before, scratch); });
}

float Bcc4Reader::base(int channel) const { return state_->bases.at(channel).value; }

float Bcc4Reader::absent(int channel) const {
  const size_t c = channel;
  if (!state_->bases.at(c).absent_is_air) return 0;
  const float air = state_->info.channels[c].air;
  return static_cast<float>(static_cast<double>(air) - base(channel));
}

std::shared_ptr<const Brick> Bcc4Reader::brick(const ChannelLevel& at, const ChunkData& data,
                                               int layer_of_slab, RelativeTo to) const {
  return brick_of_chunk(state_->coder(at, to), data, layer_of_slab);
}

TileValues Bcc4Reader::tile_values(const ChannelLevel& at, RelativeTo to) const {
  // Codes are less that of air, whatever their values are relative to.
  const SampleCoder& coder = state_->coder(at, to);
  return {static_cast<float>(coder.scale()), coder.decode(state_->coder(at).codes().air),
          to == RelativeTo::base ? absent(at.channel) : 0};
}

SampleBrick Bcc4Reader::samples(const ChannelLevel& at, const OpenTile& tile, int brick, int layer_of_slab,
                                RelativeTo to) const {
  const size_t m = layer_of_slab;
  const ChunkData& of = tile.bricks()[brick];
  if (of.first.at(m + 1) == of.first.at(m)) return {};
  return {nullptr, std::make_shared<const LayerCodes>(state_->coder(at, to), tile, brick, m)};
}

SampleBrick Bcc4Reader::samples(const ChannelLevel& at, const ChunkData& data, int layer_of_slab,
                                RelativeTo to) const {
  const size_t m = layer_of_slab;
  if (data.first.at(m + 1) == data.first.at(m)) return {};
  if (is_float(data.coded.type)) return {brick(at, data, layer_of_slab, to), {}};
  return {nullptr, std::make_shared<const LayerCodes>(state_->coder(at, to), data, m)};
}

} // namespace bccsplat
