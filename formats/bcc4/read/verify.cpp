// SPDX-License-Identifier: Apache-2.0
// Reads and checks everything a file holds, and lists the damage.
#include <algorithm>
#include <map>
#include <mutex>
#include <optional>
#include <tuple>
#include <utility>

#include "base/memory_turns.h"
#include "base/would_block.h"
#include "formats/bcc4/coding/linear_tile.h"
#include "formats/bcc4/coding/open_tile.h"
#include "formats/bcc4/read/explain.h"
#include "formats/bcc4/read/reader_state.h"

namespace bccsplat {

struct Bcc4Reader::State::Verification {
  struct Extent {
    uint64_t offset, end;
  };
  struct Totals {
    uint64_t kept = 0, holes = 0;
    uint32_t min_code = UINT32_MAX, max_code = 0;
  };

  const Bcc4Reader& reader;
  const State& file;
  const Context& context;
  Bcc4VerifyResult result{};
  Attempts attempts{};           // bytes that are not there yet are no damage
  std::vector<Extent> extents{}; // of all parts of the file
  uint64_t unread = 0;           // bytes of them that could not be read
  std::map<ChannelLevel, Totals> totals{};
  uint64_t runs = 0, values = 0; // bytes

  [[nodiscard]] Bcc4Damage damaged_slabs(const ChannelLevel& at, int32_t first, int32_t last) const;
  void add_file_damage(Code code, std::string message, uint64_t offset) {
    Bcc4Damage d;
    d.code = code, d.message = std::move(message), d.offset = offset;
    result.damage.push_back(std::move(d));
  }
  // Lists what stopped the check of a part; `lost` tells what depends on it. Throws on what says nothing of
  // the file.
  void add_failure(const Error& e, Bcc4Damage lost, uint64_t offset, uint64_t bytes) {
    // cppcheck-suppress rethrowNoCurrentException ; called from where it was caught
    if (!is_damage(e.code()) && !is_unreadable(e.code())) throw;
    const bool damaged = is_damage(e.code());
    lost.code = e.code(), lost.offset = offset;
    lost.message =
        damaged ? concat(e.message(), lost.message)
                : concat(e.message(), "; nothing is known of the ", bytes, " bytes at offset ", offset);
    if (!damaged) unread += bytes;
    (damaged ? result.damage : result.unreadable).push_back(std::move(lost));
  }
  void add_block(const BlockRef& ref) {
    result.bytes_checked += ref.padded();
    extents.push_back({ref.offset, ref.offset + ref.padded()});
  }
  void check_corrections();
  void check_masks();
  [[nodiscard]] std::optional<uint64_t> count_missing(int channel, uint64_t frame, const BlockRef& block);
  void check_sums(size_t channel, uint64_t FrameSums::*which, std::optional<uint64_t> found);
  template<class Look> void look_at(const BlockRef& block, const Look& look);
  void check_page(size_t index);
  void check_tile(const ChannelLevel& at, const Bcc4Chunk& chunk, std::span<const std::byte> stored,
                  ChunkScratch& scratch) const;
  void check_chunks(const ChannelLevel& at, const Page& page);
  void check_extents(bool pages_whole);
  void check_totals();
  [[nodiscard]] Bcc4VerifyResult check_all();
};

// The layers of slabs, of which nothing is known but their place.
Bcc4Damage Bcc4Reader::State::Verification::damaged_slabs(const ChannelLevel& at, int32_t first,
                                                          int32_t last) const {
  const StoredLattice& level = file.info.level(at.level);
  Bcc4Damage d;
  d.channel = at.channel, d.level = at.level;
  d.first_layer = first * level.slab_layers;
  d.last_layer = last * level.slab_layers + level.layers_of(last) - 1;
  return d;
}

// Counts a block that is there, and lists what look() finds wrong with it.
template<class Look> void Bcc4Reader::State::Verification::look_at(const BlockRef& block, const Look& look) {
  if (block.stored == 0) return;
  add_block(block);
  try {
    look();
  } catch (const WouldBlock& e) {
    attempts.add(e);
  } catch (const Error& e) {
    add_failure(e, {}, block.offset, block.padded());
  }
}

// found: none where some of it could not be read.
void Bcc4Reader::State::Verification::check_sums(size_t channel, uint64_t FrameSums::*which,
                                                 std::optional<uint64_t> found) {
  const ChannelInfo& c = file.info.channels[channel];
  if (!c.sums || !found || (*c.sums).*which == *found) return;
  add_file_damage(Code::corrupt,
                  concat("channel ", c.name, ": ", *found,
                         which == &FrameSums::missing ? " samples are missing" : " samples are corrected",
                         ", the metadata say ", (*c.sums).*which),
                  file.root.metadata.offset);
}

void Bcc4Reader::State::Verification::check_corrections() {
  const auto& channels = file.info.channels;
  for (size_t i = 0; i < channels.size(); ++i) {
    const ResidualInfo& fix = channels[i].residuals;
    const auto channel = static_cast<int>(i);
    std::optional<uint64_t> sum = 0; // as long as all was read
    const auto count_at = [&](const BlockRef& block, const auto& count) {
      bool whole = block.stored == 0;
      look_at(block, [&] {
        const uint64_t found = count();
        whole = true;
        if (sum) *sum += found;
      });
      if (!whole) sum.reset();
    };
    for (uint64_t f = 0; f < fix.frames.size(); ++f)
      count_at(fix.frames[f], [&] {
        const FrameResiduals whole = file.residuals(channel, f);
        return whole.add.size() + whole.set.size();
      });
    for (uint64_t f = 0; f < fix.tables.size(); ++f) {
      std::vector<CorrectionBrick> table;
      count_at(fix.tables[f], [&] {
        table = file.correction_bricks(channel, f);
        return uint64_t{0};
      });
      for (const CorrectionBrick& brick : table)
        count_at(brick.block, [&] { return file.corrections(channel, brick).size(); });
    }
    check_sums(i, &FrameSums::corrections, sum);
  }
}

// Frames that share a block share its damage.
void Bcc4Reader::State::Verification::check_masks() {
  const auto& channels = file.info.channels;
  // How many samples are missing by a block; none: it could not be read.
  std::map<std::tuple<uint64_t, uint32_t, uint32_t, uint32_t, uint32_t>, std::optional<uint64_t>> known;
  for (size_t i = 0; i < channels.size(); ++i) {
    std::optional<uint64_t> sum = 0; // as long as all was read
    for (uint64_t f = 0; f < channels[i].masks.size(); ++f) {
      const BlockRef& block = channels[i].masks[f];
      if (block.stored == 0) continue;
      const auto [at, is_new] = known.try_emplace(
          {block.offset, block.stored, block.decoded, block.crc, block.coding}, std::nullopt);
      if (is_new) at->second = count_missing(static_cast<int>(i), f, block);
      if (sum && at->second)
        *sum += *at->second;
      else
        sum.reset();
    }
    check_sums(i, &FrameSums::missing, sum);
  }
}

std::optional<uint64_t> Bcc4Reader::State::Verification::count_missing(int channel, uint64_t frame,
                                                                       const BlockRef& block) {
  add_block(block);
  uint64_t missing = 0;
  try {
    reader.mask_runs(channel, frame, [&](uint64_t begin, uint64_t end) { missing += end - begin; });
    return missing;
  } catch (const WouldBlock& e) {
    attempts.add(e);
  } catch (const Error& e) {
    Bcc4Damage lost;
    lost.message = concat("; lost: which samples of channel ", file.info.channels[channel].name,
                          " are missing, from frame ", frame, " on");
    add_failure(e, std::move(lost), block.offset, block.padded());
  }
  return std::nullopt;
}

void Bcc4Reader::State::Verification::check_page(size_t index) {
  const PageRef& ref = file.pages[index];
  result.chunks += ref.entries;
  add_block(ref.block);
  std::shared_ptr<const Page> page;
  try {
    page = file.load_page(index);
  } catch (const WouldBlock& e) {
    attempts.add(e);
    return;
  } catch (const Error& e) {
    if (is_damage(e.code())) result.chunks_damaged += ref.entries;
    Bcc4Damage d = damaged_slabs(ref.at(), ref.first_slab, ref.last_slab);
    d.whole_layers = true;
    add_failure(e, std::move(d), ref.block.offset, ref.block.padded());
    return;
  }
  check_chunks(ref.at(), *page);
  Totals& t = totals[ref.at()];
  for (const Bcc4Chunk& c : *page) {
    extents.push_back({c.offset, c.offset + c.stored()});
    result.bytes_checked += c.stored();
    runs += c.runs_bytes, values += c.values_bytes;
    t.kept += c.kept, t.holes += c.holes;
    t.min_code = std::min(t.min_code, c.min_code), t.max_code = std::max(t.max_code, c.max_code);
  }
}

// Whoever reads some bricks of a tile cannot know whether the range of its codes is its own.
void Bcc4Reader::State::Verification::check_tile(const ChannelLevel& at, const Bcc4Chunk& chunk,
                                                 std::span<const std::byte> stored,
                                                 ChunkScratch& scratch) const {
  const ChunkData tile = file.decode(at, chunk, stored, scratch);
  const auto [low, high] = tile.linear ? tile.linear->range(tile.coded) : tile.tile->range();
  if (low != chunk.min_code || high != chunk.max_code)
    fail(Code::corrupt, "chunk at offset ", chunk.offset, ": codes ", low, " .. ", high, ", the index says ",
         chunk.min_code, " .. ", chunk.max_code);
}

void Bcc4Reader::State::Verification::check_chunks(const ChannelLevel& at, const Page& page) {
  std::mutex mutex;
  MemoryTurns turns(context.memory);
  const std::vector<ChunkGroup> groups = group_chunks(page, usual_merge_gap);
  context.tasks.parallel_for(groups.size(), [&](uint64_t g) {
    context.progress.check();
    ChunkScratch scratch;
    for (const size_t i : groups[g].members) {
      const Bcc4Chunk& c = page[i];
      try {
        std::vector<std::byte> stored(c.stored());
        file.read(c.offset, stored);
        if (file.info.tile_edge > 1)
          turns.run(reader.decoding_bytes(at, c), "decoding a tile",
                    [&] { check_tile(at, c, stored, scratch); });
        else
          static_cast<void>(file.decode(at, c, stored, scratch));
      } catch (const WouldBlock& e) {
        attempts.add(e);
      } catch (const Error& e) {
        Bcc4Damage d = damaged_slabs(at, c.slab, c.slab);
        d.brick = file.brick_of(c.slot, at.level);
        const std::scoped_lock lock(mutex);
        if (is_damage(e.code())) ++result.chunks_damaged;
        add_failure(e, std::move(d), c.offset, c.stored());
      }
    }
  });
}

// No two parts share bytes; where the pages are whole, the bytes of all parts are those that the root counts.
void Bcc4Reader::State::Verification::check_extents(bool pages_whole) {
  std::sort(extents.begin(), extents.end(),
            [](const Extent& a, const Extent& b) { return a.offset < b.offset; });
  uint64_t end = preamble_bytes, unused = 0;
  for (const Extent& e : extents) {
    if (e.offset < end && e.end > e.offset)
      add_file_damage(Code::corrupt, concat("two parts share the bytes at offset ", e.offset), e.offset);
    unused += e.offset > end ? e.offset - end : 0;
    end = std::max(end, e.end);
  }
  unused += file.root.file_bytes - end;
  if (pages_whole && result.unreadable.empty() &&
      (unused != file.bytes.unused || runs != file.root.runs_bytes || values != file.root.values_bytes))
    add_file_damage(Code::corrupt, "the root's sums of bytes differ from the index", root_offset);
}

void Bcc4Reader::State::Verification::check_totals() {
  const auto check = [&](const ChannelLevel& at, const auto& told, const std::string& what) {
    const Totals& t = totals[at];
    const SampleCoder& coder = file.coder(at);
    const Range range = t.kept ? Range{coder.value(t.min_code), coder.value(t.max_code)} : Range{};
    if (t.kept != told.sites_kept || t.holes != told.holes || range != told.kept_range)
      add_file_damage(Code::corrupt, concat(what, ": counts or range differ from the index"),
                      file.root.metadata.offset);
  };
  for (int c = 0; c < static_cast<int>(file.info.channels.size()); ++c) {
    const ChannelInfo& channel = file.info.channels[c];
    check(c, channel, concat("channel ", channel.name));
    for (int l = 1; l < file.info.level_count(); ++l)
      check({c, l}, file.info.levels[static_cast<size_t>(l) - 1].channels[c],
            concat("channel ", channel.name, ", level ", l));
  }
}

Bcc4VerifyResult Bcc4Reader::State::Verification::check_all() {
  result.bytes_checked = preamble_bytes;
  if (file.root_damaged)
    add_file_damage(Code::checksum_mismatch,
                    "the root record is damaged, or its replacing was interrupted; a copy of it is read",
                    root_offset);
  add_block(file.root.metadata);
  add_block(file.root.directory);
  check_corrections();
  check_masks();
  for (size_t p = 0; p < file.pages.size(); ++p) {
    context.progress.report(static_cast<double>(p) / static_cast<double>(file.pages.size()));
    check_page(p);
  }
  attempts.throw_if_waiting();
  bool pages_whole = true;
  for (auto* places : {&result.damage, &result.unreadable}) {
    pages_whole = pages_whole && std::none_of(places->begin(), places->end(),
                                              [](const Bcc4Damage& d) { return d.whole_layers; });
    std::stable_sort(places->begin(), places->end(),
                     [](const Bcc4Damage& a, const Bcc4Damage& b) { return a.offset < b.offset; });
  }
  check_extents(pages_whole);
  if (pages_whole) check_totals();

  for (Bcc4Damage& d : result.damage) d.message += describe_loss(file.info, d);
  std::vector<Bcc4Damage> lost = result.damage;
  lost.insert(lost.end(), result.unreadable.begin(), result.unreadable.end());
  if (!lost.empty()) result.survivors = describe_survivors(file.info, lost);
  result.bytes_checked -= unread;
  context.progress.report(1);
  return std::move(result);
}

Bcc4VerifyResult Bcc4Reader::verify_all(const Context& context) const {
  return State::Verification{*this, *state_, context}.check_all();
}

} // namespace bccsplat
