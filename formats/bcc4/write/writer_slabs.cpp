// SPDX-License-Identifier: Apache-2.0
// Brings a slab into the file: codes its chunks side by side, finds them in what an earlier writer left, or
// copies them from an earlier file; and records in the journal what is safe on disk.
#include <algorithm>
#include <vector>

#include "formats/bcc4/coding/chunk.h"
#include "formats/bcc4/coding/codes.h"
#include "formats/bcc4/encode/encode_chunk.h"
#include "formats/bcc4/write/chunk_sites.h"
#include "formats/bcc4/write/writer_state.h"

namespace bccsplat {
namespace {

constexpr size_t chunks_at_once = 256; // encoded together, which bounds the memory of a slab

// Returns the slots of which any layer keeps a site.
std::vector<uint32_t> kept_slots(const StoredLattice& level, std::span<const SampleLayer> layers) {
  const Int3 dims = slot_dims(level);
  std::vector<uint32_t> slots;
  for (uint32_t s = 0; s < slot_count(level); ++s)
    if (std::any_of(layers.begin(), layers.end(), [&](const SampleLayer& l) {
          return static_cast<bool>(brick_at(l, slot_brick(dims, s, 1)));
        }))
      slots.push_back(s);
  return slots;
}

struct CodedChunk {
  std::optional<EncodedChunk> chunk; // none: all of it is air
  uint64_t clamped = 0;
};

} // namespace

void Bcc4Writer::State::append_chunk(const ChannelLevel& at, const EncodedChunk& chunk,
                                     WrittenSlab& written) {
  Bcc4Chunk entry = chunk.entry;
  entry.slab = written.slab;
  entry.offset = file.position();
  file.append(chunk.bytes);
  index->enter_chunk(at, entry);
  written.chunks.push_back(entry);
}

WrittenSlab Bcc4Writer::State::encode_slab(int32_t slab, const ChannelLevel& at,
                                           std::span<const SampleLayer> layers, const Context& context) {
  const SampleCoder& coder = index->coder(at);
  const StoredLattice& level = info.level(at.level);
  const Int3 dims = slot_dims(level);
  // Air may lie between two codes where a range is spread over them: then only what is left out is air.
  const bool air_has_code = coder.decode(coder.codes().air) == 0;
  const auto encode = [&](uint32_t slot) {
    const Int3 brick = slot_brick(dims, slot, 1);
    const ChunkShape shape =
        chunk_shape(level.lattice, slab * level.slab_layers, static_cast<int32_t>(layers.size()), brick);
    CodedChunk coded;
    ChunkSites sites = collect_sites(shape, layers, brick, coder, coded.clamped);
    if (air_has_code) keep_scattered_air(sites, coder.codes());
    if (!sites.codes.empty()) coded.chunk = encode_chunk(sites, coder.codes(), options.level);
    return coded;
  };
  WrittenSlab written{.slab = slab, .at = at, .chunks = {}};
  const std::vector<uint32_t> slots = kept_slots(level, layers);
  for (size_t first = 0; first < slots.size(); first += chunks_at_once) {
    std::vector<CodedChunk> batch(std::min(chunks_at_once, slots.size() - first));
    context.tasks.parallel_for(batch.size(), [&](uint64_t i) {
      context.progress.check();
      batch[i] = encode(slots[first + i]);
    });
    for (size_t i = 0; i < batch.size(); ++i) {
      written.clamped += batch[i].clamped;
      if (!batch[i].chunk) continue;
      batch[i].chunk->entry.slot = slots[first + i];
      append_chunk(at, *batch[i].chunk, written);
    }
  }
  return written;
}

// Lists the chunks of an earlier writer, which are where they would go. Pages of the index come between.
void Bcc4Writer::State::skip_chunks(const WrittenSlab& slab) {
  for (const Bcc4Chunk& entry : slab.chunks) {
    if (entry.offset != file.position())
      fail(Code::wrong_state, "writer: the unfinished file has slab ", slab.slab, " at offset ", entry.offset,
           " instead of ", file.position(),
           ": other samples were given for what was written before; the file and its journal are as they "
           "were: "
           "give the same samples, or start anew without resuming");
    file.skip(entry.stored());
    index->enter_chunk(slab.at, entry);
  }
}

const WrittenSlab* Bcc4Writer::State::in_journal(int32_t slab, const ChannelLevel& at, int32_t layers) const {
  const WrittenSlab* const found = options.journal ? options.journal->find(slab, at) : nullptr;
  return found && found->layers == layers ? found : nullptr;
}

bool Bcc4Writer::State::in_earlier(int32_t slab, const ChannelLevel& at, int32_t layers) const {
  return options.earlier && slab < options.earlier_slabs && layers == info.level(at.level).slab_layers;
}

// Takes a slab over from an earlier writer or an earlier file; none: it is to be coded.
std::optional<WrittenSlab> Bcc4Writer::State::reuse_slab(int32_t slab, const ChannelLevel& at,
                                                         int32_t layers) {
  if (const WrittenSlab* const found = in_journal(slab, at, layers)) {
    skip_chunks(*found);
    return *found;
  }
  if (!in_earlier(slab, at, layers)) return std::nullopt;
  const Bcc4Reader* const earlier = options.earlier.get();
  return copy_chunks(slab, at, {&earlier, 1});
}

WrittenSlab Bcc4Writer::State::copy_chunks(int32_t slab, const ChannelLevel& at,
                                           std::span<const Bcc4Reader* const> from) {
  struct Found {
    Bcc4Chunk entry;
    const Bcc4Reader* source;
  };
  std::vector<Found> found;
  for (const Bcc4Reader* const source : from)
    for (const Bcc4Chunk& entry : source->chunks(at, slab)) found.push_back({entry, source});
  std::stable_sort(found.begin(), found.end(),
                   [](const Found& a, const Found& b) { return a.entry.slot < b.entry.slot; });
  WrittenSlab written{.slab = slab, .at = at, .chunks = {}};
  for (auto& [entry, source] : found) {
    if (!written.chunks.empty() && written.chunks.back().slot == entry.slot)
      fail(Code::invalid_argument, "writer: two files have chunk ", entry.slot, " of slab ", slab);
    const std::vector<std::byte> bytes = source->stored_bytes(entry);
    entry.offset = file.position();
    file.append(bytes);
    index->enter_chunk(at, entry);
    written.chunks.push_back(entry);
  }
  return written;
}

void Bcc4Writer::State::commit_pending() {
  file.sync();
  options.journal->commit();
}

void Bcc4Writer::State::keep() noexcept {
  if (closed || !options.journal) return;
  try {
    commit_pending();
  } catch (...) {
  }
}

void Bcc4Writer::State::write_slab(int32_t slab, const ChannelLevel& at, std::span<const SampleLayer> layers,
                                   double rounded, const Context& context) {
  const auto count = static_cast<int32_t>(layers.size());
  std::optional<WrittenSlab> written = reuse_slab(slab, at, count);
  const bool reused = written.has_value();
  if (!written)
    written = info.tile_edge > 1 ? encode_tiles(slab, at, layers, rounded, context)
                                 : encode_slab(slab, at, layers, context);
  written->layers = count;
  slabs_reused += reused;
  if (options.journal && !options.journal->find(slab, at)) {
    options.journal->add(*written);
    if (options.journal->commit_is_due()) commit_pending();
  }
  index->enter_slab(slab, at, count, written->clamped);
}

} // namespace bccsplat
