// SPDX-License-Identifier: Apache-2.0
// Opens a file, finds the chunks of a slab in its index, reads and decodes them; when salvaging, what is
// damaged becomes holes.
#include <algorithm>
#include <bit>
#include <cstring>
#include <numeric>
#include <tuple>

#include "base/would_block.h"
#include "formats/bcc4/bcc4.h"
#include "formats/bcc4/coding/deflate.h"
#include "formats/bcc4/coding/layer_codes.h"
#include "formats/bcc4/coding/spread.h"
#include "formats/bcc4/field_base.h"
#include "formats/bcc4/metadata.h"
#include "formats/bcc4/reader_state.h"

namespace bccsplat {
namespace {

constexpr uint64_t group_bytes = 256 << 10; // of chunks that one task reads and decodes
// Of a read, where reads cost so much that gaps this wide are read along.
constexpr uint64_t gaps_per_group = 16;
constexpr size_t most_lost = 1 << 20; // chunks that one damaged page may have listed

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

// The series as far as an unfinished file can be looked at: of fewer frames, on the layers that are there.
VolumeInfo Bcc4Reader::State::shown_part(const std::string& name, uint16_t lowest_version) const {
  const uint32_t frames = root.frames;
  if (lowest_version < 3)
    fail(Code::corrupt, name, ": it says that readers of version ", lowest_version,
         " can read it, but is unfinished, which came with version 3");
  if (frames > info.lattice.dims[3])
    fail(Code::corrupt, name, ": the root says that ", frames, " frames can be looked at, the series has ",
         info.lattice.dims[3]);
  VolumeInfo part = info;
  part.unfinished = true;
  part.lattice.dims[3] = frames;
  for (LevelInfo& level : part.levels) level.lattice.dims[3] = frames;
  const auto cut = [&](auto& list) {
    if (!list.empty()) list.resize(frames);
  };
  cut(part.time.times);
  for (ChannelInfo& c : part.channels)
    cut(c.frames), cut(c.residuals.frames), cut(c.residuals.tables), cut(c.masks);
  return part;
}

void Bcc4Reader::State::open() {
  const std::string& name = source->name();
  std::vector<std::byte> head(std::min(source->size(), preamble_bytes));
  read(0, head);
  Preamble preamble = read_preamble(head, name);
  root = *preamble.root;
  root_damaged = preamble.root_damaged;
  if (root.file_bytes > source->size() && !limits.salvage)
    fail(Code::truncated, name, ": ", source->size(), " bytes of ", root.file_bytes, "; it was cut short");
  if (root.metadata.decoded > limits.metadata_bytes)
    fail(Code::limit_exceeded, name, ": metadata of ", root.metadata.decoded, " bytes, the limit is ",
         limits.metadata_bytes);
  if (root.directory.decoded > limits.directory_bytes)
    fail(Code::limit_exceeded, name, ": index directory of ", root.directory.decoded, " bytes, the limit is ",
         limits.directory_bytes);
  std::vector<std::byte> metadata, directory;
  Attempts attempts; // both before an opening that has to wait gives up
  attempts.attempt([&] { metadata = read_block(root.metadata, "metadata"); });
  if (attempts.waits()) attempts.attempt([&] { directory = read_block(root.directory, "index directory"); });
  attempts.throw_if_waiting();
  info = read_metadata(metadata, root.metadata.offset, limits);
  if (lowest_reader(info) > preamble.lowest_reader)
    fail(Code::corrupt, name, ": it says that readers of version ", preamble.lowest_reader,
         " can read it, but holds what came with version ", lowest_reader(info));
  if (root.unfinished) shown = shown_part(name, preamble.lowest_reader);
  directory = read_block(root.directory, "index directory");
  pages = read_directory(directory, info, root, root.directory.offset);
  for (const ChannelInfo& c : info.channels) bases.push_back(field_base(info, c));
  for (int level = 0; level < info.level_count(); ++level) {
    slots.push_back(slot_dims(info.level(level).lattice));
    for (size_t c = 0; c < bases.size(); ++c) {
      const Quantiser coding = info.coding({static_cast<int>(c), level});
      coders.emplace_back(coding);
      const float zero = stored_base(coding.air, bases[c].value, info.lattice, info.coefficient_kernel);
      from_base.push_back(zero == coding.air ? coders.back() : SampleCoder(coding, zero));
    }
  }
  bytes.file = root.file_bytes;
  bytes.runs = root.runs_bytes, bytes.values = root.values_bytes, bytes.index = root.index_bytes;
  bytes.unused = root.file_bytes - root.runs_bytes - root.values_bytes - root.index_bytes;
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
  cached.insert(index, loaded, 1, 0);
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
                                    std::span<const std::byte> stored, ChunkScratch& scratch) const {
  return decode_chunk(shape_of(chunk, at.level), coder(at).codes(), chunk, stored, scratch);
}

Page Bcc4Reader::State::lost_page(const PageRef& ref) const {
  const auto count = static_cast<uint32_t>(slot_count(info.level(ref.at().level).lattice));
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
  ChunkData data = chunk_of_holes(shape_of(chunk, at.level), coder(at).codes());
  data.lost = true;
  return data;
}

ChunkData Bcc4Reader::State::decode_or_lose(const ChannelLevel& at, const Bcc4Chunk& chunk,
                                            std::span<const std::byte> stored, ChunkScratch& scratch) const {
  if (!limits.salvage) return in_file([&] { return decode(at, chunk, stored, scratch); });
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

std::shared_ptr<Bcc4Reader> Bcc4Reader::open(std::unique_ptr<ByteSource> source, const Bcc4Limits& limits) {
  auto state = std::make_unique<State>(std::move(source), limits);
  state->in_file([&] { state->open(); });
  return std::shared_ptr<Bcc4Reader>(new Bcc4Reader(std::move(state)));
}

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
        if (region.contains(s.brick_of(c->slot, at.level))) found.push_back(*c);
    });
  attempts.throw_if_waiting();
  return found;
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

std::vector<std::byte> Bcc4Reader::stored_bytes(const Bcc4Chunk& chunk) const {
  std::vector<std::byte> stored(chunk.stored());
  state_->read(chunk.offset, stored);
  if (crc32_of(stored) != chunk.crc)
    fail(Code::checksum_mismatch, "chunk at offset ", chunk.offset, ": bad checksum");
  return stored;
}

std::vector<std::shared_ptr<const ChunkData>> Bcc4Reader::read_chunks(const ChannelLevel& at,
                                                                      std::span<const Bcc4Chunk> chunks,
                                                                      const Context& context,
                                                                      Attempts& attempts) const {
  std::vector<std::shared_ptr<const ChunkData>> out(chunks.size());
  const std::vector<ChunkGroup> groups = group_chunks(chunks, merge_gap());
  context.tasks.parallel_for(groups.size(), [&](uint64_t g) {
    context.progress.check();
    std::vector<std::byte> stored(groups[g].bytes);
    bool read = false;
    if (!attempts.attempt([&] { read = state_->read_or_lose(groups[g].offset, stored); })) return;
    ChunkScratch scratch;
    for (const size_t i : groups[g].members) {
      auto part = std::span<const std::byte>(stored);
      part = read ? part.subspan(chunks[i].offset - groups[g].offset, chunks[i].stored()) : part.first(0);
      out[i] = std::make_shared<const ChunkData>(state_->decode_or_lose(at, chunks[i], part, scratch));
    }
  });
  return out;
}

std::vector<std::shared_ptr<const ChunkData>> Bcc4Reader::read_chunks(const ChannelLevel& at,
                                                                      std::span<const Bcc4Chunk> chunks,
                                                                      const Context& context) const {
  Attempts attempts;
  auto out = read_chunks(at, chunks, context, attempts);
  attempts.throw_if_waiting();
  return out;
}

namespace {

// The block of a frame; null where it has none.
const BlockRef* block_of(const std::vector<BlockRef>& frames, uint64_t frame) {
  return frame < frames.size() && frames[frame].stored > 0 ? &frames[frame] : nullptr;
}

} // namespace

FrameResiduals Bcc4Reader::State::residuals(int channel, uint64_t frame) const {
  const ResidualInfo& fix = info.channels.at(static_cast<size_t>(channel)).residuals;
  const BlockRef* ref = block_of(fix.frames, frame);
  if (!ref) return {};
  check_block_ref(*ref, "corrections", root.file_bytes);
  const auto& n = info.lattice.dims;
  FrameResiduals all =
      read_residuals(read_block(*ref, "corrections"), uint64_t{n[0]} * n[1] * n[2], ref->offset);
  if (fix.local && !all.add.empty())
    fail(Code::corrupt, "corrections at offset ", ref->offset, ": some to add, which stand in bricks");
  return all;
}

std::vector<CorrectionBrick> Bcc4Reader::State::correction_bricks(int channel, uint64_t frame) const {
  const BlockRef* ref = block_of(info.channels.at(static_cast<size_t>(channel)).residuals.tables, frame);
  if (!ref) return {};
  check_block_ref(*ref, "table of corrections", root.file_bytes);
  return read_correction_table(read_block(*ref, "table of corrections"), CorrectionBricks(info.lattice.dims),
                               ref->offset, root.file_bytes);
}

ResidualList Bcc4Reader::State::corrections(int channel, const CorrectionBrick& brick) const {
  constexpr auto edge = static_cast<uint64_t>(correction_edge);
  ResidualList list =
      read_corrections(read_block(brick.block, "corrections"), edge * edge * edge, brick.block.offset);
  CorrectionBricks(info.lattice.dims)
      .check(brick, list, info.channels.at(static_cast<size_t>(channel)).residuals.step);
  return list;
}

namespace {

// What read() returns; nothing where it fails on what a salvaged file goes without.
template<class Read> auto read_or_leave(const Bcc4Reader& reader, const Read& read) -> decltype(read()) {
  try {
    return read();
  } catch (const Error& e) {
    if (!reader.goes_without(e)) throw;
    return {};
  }
}

} // namespace

FrameResiduals Bcc4Reader::residuals(int channel, uint64_t frame) const {
  return read_or_leave(*this,
                       [&] { return state_->in_file([&] { return state_->residuals(channel, frame); }); });
}
std::vector<CorrectionBrick> Bcc4Reader::correction_bricks(int channel, uint64_t frame) const {
  return read_or_leave(
      *this, [&] { return state_->in_file([&] { return state_->correction_bricks(channel, frame); }); });
}
ResidualList Bcc4Reader::corrections(int channel, const CorrectionBrick& brick) const {
  return read_or_leave(*this,
                       [&] { return state_->in_file([&] { return state_->corrections(channel, brick); }); });
}

void Bcc4Reader::mask_runs(int channel, uint64_t frame, const MaskRunBody& body) const {
  const BlockRef* ref = block_of(info().channels.at(static_cast<size_t>(channel)).masks, frame);
  if (!ref) return;
  const auto& n = info().lattice.dims;
  state_->in_file([&] {
    check_block_ref(*ref, "mask", state_->root.file_bytes);
    read_mask_runs(state_->read_block(*ref, "mask"), uint64_t{n[0]} * n[1] * n[2], ref->offset, body);
  });
}

std::vector<std::byte> Bcc4Reader::stored_block(const BlockRef& block, std::string_view what) const {
  check_block_ref(block, what, state_->root.file_bytes);
  std::vector<std::byte> stored(block.padded());
  state_->read(block.offset, stored);
  if (crc32_of(stored) != block.crc)
    fail(Code::checksum_mismatch, what, " at offset ", block.offset, ": bad checksum");
  return stored;
}

float Bcc4Reader::base(int channel) const { return state_->bases.at(static_cast<size_t>(channel)).value; }

float Bcc4Reader::absent(int channel) const {
  const auto c = static_cast<size_t>(channel);
  if (!state_->bases.at(c).absent_is_air) return 0;
  const float air = state_->info.channels[c].air;
  const float zero = stored_base(air, base(channel), state_->info.lattice, state_->info.coefficient_kernel);
  return static_cast<float>(static_cast<double>(air) - static_cast<double>(zero));
}

std::shared_ptr<const Brick> Bcc4Reader::brick(const ChannelLevel& at, const ChunkData& data,
                                               int layer_of_slab, RelativeTo to) const {
  const auto m = static_cast<size_t>(layer_of_slab);
  const uint32_t first = data.first.at(m);
  if (data.first.at(m + 1) == first) return nullptr;
  auto brick = std::make_shared_for_overwrite<Brick>();
  brick->kept = data.kept[m];
  if (!data.hole.empty() && data.hole[m] != BrickMask{})
    brick->hole = std::make_unique<BrickMask>(data.hole[m]);
  spread_codes(state_->coder(at, to), data.coded, brick->kept, data.codes, first, brick->value);
  return brick;
}

SampleBrick Bcc4Reader::samples(const ChannelLevel& at, const ChunkData& data, int layer_of_slab,
                                RelativeTo to) const {
  const auto m = static_cast<size_t>(layer_of_slab);
  if (data.first.at(m + 1) == data.first.at(m)) return {};
  if (is_float(data.coded.type) || data.coded.bytes() > 2) return {brick(at, data, layer_of_slab, to), {}};
  return {nullptr, std::make_shared<const LayerCodes>(state_->coder(at, to), data, m)};
}

} // namespace bccsplat
