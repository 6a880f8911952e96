// SPDX-License-Identifier: Apache-2.0
// Writes a file in one pass: chunks slab by slab, each page of the index when it is full, and at the end
// directory, metadata and roots. Slabs of an earlier writer or file are taken over without coding them again.
#include <algorithm>
#include <array>
#include <optional>
#include <set>
#include <utility>

#include "formats/bcc4/bcc4.h"
#include "formats/bcc4/chunk_sites.h"
#include "formats/bcc4/coding/chunk.h"
#include "formats/bcc4/coding/codes.h"
#include "formats/bcc4/coding/deflate.h"
#include "formats/bcc4/journal.h"
#include "formats/bcc4/layout.h"
#include "formats/bcc4/mask_blocks.h"
#include "formats/bcc4/metadata.h"
#include "formats/bcc4/page.h"
#include "formats/bcc4/writer_index.h"

namespace bccsplat {
namespace {

constexpr size_t batch_chunks = 256;       // encoded together, which bounds the memory of a slab
constexpr size_t write_bytes = 1u << 20;   // handed to the sink together
constexpr uint16_t unfinished_version = 3; // of the format, that a reader of an unfinished series needs

// What a channel has beside chunks.
struct ChannelBlocks {
  std::vector<BlockRef> residuals, tables; // of corrections, by frame
  std::vector<BlockRef> masks;             // by frame
};

[[nodiscard]] bool same_layers(const StoredLattice& a, const StoredLattice& b) {
  return a.slab_layers == b.slab_layers && a.lattice.kind == b.lattice.kind &&
         a.lattice.space == b.lattice.space && a.lattice.time_step == b.lattice.time_step &&
         a.lattice.lead == b.lattice.lead && a.lattice.periodic == b.lattice.periodic;
}

// Whether two infos agree in what may not change once samples are written.
[[nodiscard]] bool same_coding(const VolumeInfo& a, const VolumeInfo& b) {
  if (a.channels.size() != b.channels.size() || a.levels.size() != b.levels.size()) return false;
  for (int l = 0; l < a.level_count(); ++l) {
    if (!same_layers(a.level(l), b.level(l))) return false;
    for (int c = 0; c < static_cast<int>(a.channels.size()); ++c)
      if (a.coding({c, l}) != b.coding({c, l})) return false;
  }
  return true;
}

} // namespace

struct Bcc4Writer::State {
  State(std::unique_ptr<ByteSink> s, const VolumeInfo& initial, const Bcc4WriterOptions& o)
      : sink(std::move(s)), options(o), info(initial) {
    if (options.level < 0 || options.level > 9)
      fail(Code::invalid_argument, "writer: level ", options.level, " is not in 0 .. 9");
    check_fixed(info, Code::invalid_argument);
    position = std::max(preamble_bytes, (options.data_offset + 7) / 8 * 8);
    unused = position - preamble_bytes;
  }

  std::unique_ptr<ByteSink> sink;
  Bcc4WriterOptions options;
  VolumeInfo info, fixed;           // fixed: as it was when the first samples came
  std::optional<WriterIndex> index; // from the first samples on
  std::vector<ChannelBlocks> blocks;
  MaskBlocks mask_blocks;
  uint64_t position = 0; // where the next bytes go, those in `buffer` included
  std::vector<std::byte> buffer;
  uint64_t unused = 0;
  uint64_t slabs_reused = 0, correction_bytes = 0;
  uint64_t shown = 0;       // roots written so far
  uint64_t replaced = 0;    // bytes of tables that were shown before the last time
  uint64_t shown_bytes = 0; // of those of the last time
  bool closed = false;      // finished, or failed half way

  void append(std::span<const std::byte> bytes) {
    buffer.insert(buffer.end(), bytes.begin(), bytes.end());
    position += bytes.size();
    if (buffer.size() >= write_bytes) flush();
  }
  void flush() {
    if (buffer.empty()) return;
    sink->write_at(position - buffer.size(), buffer);
    buffer.clear();
  }
  [[nodiscard]] BlockRef append_block(PackedBlock block) {
    block.ref.offset = position;
    append(block.bytes);
    return block.ref;
  }

  void start() {
    if (!index) {
      check_fixed(info, Code::invalid_argument);
      fixed = info;
      index.emplace(info,
                    [this](std::span<const std::byte> decoded) { return append_block(pack_block(decoded)); });
      blocks.resize(info.channels.size());
      if (options.journal) {
        VolumeInfo tidied = info;
        tidy(tidied);
        const std::array<uint32_t, 3> parts{crc32_of(write_metadata(tidied)), options.fingerprint,
                                            static_cast<uint32_t>(options.level)};
        options.journal->start(crc32_of(std::as_bytes(std::span(parts))));
      }
    } else if (!same_coding(info, fixed)) {
      fail(Code::wrong_state, "writer: lattice or coding of a channel changed after samples were written");
    }
  }

  void check_layers(int32_t slab, const ChannelLevel& at, std::span<const SampleLayer> layers) const {
    const auto bad = [&](const auto&... why) {
      fail(Code::invalid_argument, "writer: slab ", slab, " of channel ", at.channel, ", level ", at.level,
           ": ", why...);
    };
    const StoredLattice& level = info.level(at.level);
    if (layers.empty() || layers.size() > static_cast<size_t>(level.slab_layers))
      bad(layers.size(), " layers");
    for (size_t m = 0; m < layers.size(); ++m) {
      const int coset = level.lattice.coset(slab * level.slab_layers + static_cast<int32_t>(m));
      if (!(layers[m].lattice() == level.lattice.space) || layers[m].coset() != coset)
        bad("layer ", m, " is not of coset ", coset, " of the lattice");
    }
  }

  void write_slab(int32_t slab, const ChannelLevel& at, std::span<const SampleLayer> layers,
                  const Context& context);
  WrittenSlab encode_slab(int32_t slab, const ChannelLevel& at, std::span<const SampleLayer> layers,
                          const Context& context);
  [[nodiscard]] std::optional<WrittenSlab> reuse_slab(int32_t slab, const ChannelLevel& at, int32_t layers);
  WrittenSlab copy_chunks(int32_t slab, const ChannelLevel& at, const Bcc4Reader& from);
  void commit_journal(const WrittenSlab& written);
  void commit_pending();
  void keep() noexcept;
  [[nodiscard]] ChannelBlocks& blocks_of(int channel);
  void write_corrections(int channel, uint32_t frame, std::span<const ResidualSample> list,
                         const Context& context);
  void copy_corrections(int channel, uint32_t frame, const Bcc4Reader& from);
  void add_table(int channel, uint32_t frame, std::span<const CorrectionBrick> table);
  [[nodiscard]] BlockRef add_corrections(PackedBlock block);
  [[nodiscard]] BlockRef copy_block(const BlockRef& block, const Bcc4Reader& from);
  void add_mask(int channel, uint32_t frame, PackedBlock block);
  void take_blocks(VolumeInfo& to) const;
  [[nodiscard]] uint64_t masks_beyond(uint32_t frames) const;
  [[nodiscard]] Root append_state(const VolumeInfo& of, std::span<const PageRef> pages, uint64_t beyond);
  void show(VolumeInfo of, const Context& context);
  [[nodiscard]] Bcc4Report finish(const Context& context);
};

WrittenSlab Bcc4Writer::State::encode_slab(int32_t slab, const ChannelLevel& at,
                                           std::span<const SampleLayer> layers, const Context& context) {
  const SampleCoder& coder = index->coder(at);
  const StoredLattice& level = info.level(at.level);
  WrittenSlab written{.slab = slab, .at = at, .chunks = {}};
  const Int3 dims = slot_dims(level.lattice);
  std::vector<uint32_t> slots;
  for (uint32_t s = 0; s < slot_count(level.lattice); ++s)
    if (std::any_of(layers.begin(), layers.end(), [&](const SampleLayer& l) {
          return static_cast<bool>(brick_at(l, slot_brick(dims, s)));
        }))
      slots.push_back(s);
  struct Result {
    std::optional<EncodedChunk> chunk;
    uint64_t clamped = 0;
  };
  for (size_t first = 0; first < slots.size(); first += batch_chunks) {
    std::vector<Result> results(std::min(batch_chunks, slots.size() - first));
    context.tasks.parallel_for(results.size(), [&](uint64_t i) {
      context.progress.check();
      const Int3 brick = slot_brick(dims, slots[first + i]);
      const ChunkShape shape =
          chunk_shape(level.lattice, slab * level.slab_layers, static_cast<int32_t>(layers.size()), brick);
      ChunkSites sites = collect_sites(shape, layers, brick, coder, results[i].clamped);
      keep_scattered_air(sites, coder.codes());
      if (!sites.codes.empty())
        results[i].chunk = encode_chunk(std::move(sites), coder.codes(), options.level);
    });
    for (size_t i = 0; i < results.size(); ++i) {
      written.clamped += results[i].clamped;
      if (!results[i].chunk) continue;
      Bcc4Chunk& entry = results[i].chunk->entry;
      entry.slab = slab;
      entry.slot = slots[first + i];
      entry.offset = position;
      append(results[i].chunk->bytes);
      index->enter_chunk(at, entry);
      written.chunks.push_back(entry);
    }
  }
  return written;
}

// Takes a slab over from an earlier writer, whose chunks are where they would go, or from an earlier file.
std::optional<WrittenSlab> Bcc4Writer::State::reuse_slab(int32_t slab, const ChannelLevel& at,
                                                         int32_t layers) {
  if (options.journal) {
    const WrittenSlab* found = options.journal->find(slab, at);
    if (found && found->layers == layers) {
      flush();
      for (const Bcc4Chunk& entry : found->chunks) {
        flush(); // a page may have come between
        if (entry.offset != position)
          fail(Code::wrong_state, "writer: the unfinished file has slab ", slab, " at offset ", entry.offset,
               " instead of ", position, "; start anew without resuming");
        position += entry.stored();
        index->enter_chunk(at, entry);
      }
      return *found;
    }
  }
  if (!options.earlier || slab >= options.earlier_slabs || layers != info.level(at.level).slab_layers)
    return std::nullopt;
  return copy_chunks(slab, at, *options.earlier);
}

WrittenSlab Bcc4Writer::State::copy_chunks(int32_t slab, const ChannelLevel& at, const Bcc4Reader& from) {
  WrittenSlab written{.slab = slab, .at = at, .chunks = from.chunks(at, slab)};
  for (Bcc4Chunk& entry : written.chunks) {
    const std::vector<std::byte> bytes = from.stored_bytes(entry);
    entry.offset = position;
    append(bytes);
    index->enter_chunk(at, entry);
  }
  return written;
}

void Bcc4Writer::State::commit_journal(const WrittenSlab& written) {
  options.journal->add(written);
  if (options.journal->commit_is_due()) commit_pending();
}

void Bcc4Writer::State::commit_pending() {
  flush();
  sink->flush();
  options.journal->commit();
}

// A writer that is let go before it has finished leaves a journal of all that it has coded. Where that fails,
// some of it will be coded again.
void Bcc4Writer::State::keep() noexcept {
  if (closed || !options.journal) return;
  try {
    commit_pending();
  } catch (...) {
  }
}

void Bcc4Writer::State::write_slab(int32_t slab, const ChannelLevel& at, std::span<const SampleLayer> layers,
                                   const Context& context) {
  const auto count = static_cast<int32_t>(layers.size());
  std::optional<WrittenSlab> written = reuse_slab(slab, at, count);
  const bool reused = written.has_value();
  if (!written) written = encode_slab(slab, at, layers, context);
  written->layers = count;
  slabs_reused += reused;
  if (options.journal && !options.journal->find(slab, at)) commit_journal(*written);
  index->enter_slab(slab, at, count, written->clamped);
}

// The blocks of the frames that the info has.
void Bcc4Writer::State::take_blocks(VolumeInfo& to) const {
  for (size_t i = 0; i < blocks.size(); ++i) {
    ChannelInfo& out = to.channels[i];
    out.residuals.frames = blocks[i].residuals, out.residuals.tables = blocks[i].tables;
    out.masks = blocks[i].masks;
    for (auto* frames : {&out.residuals.frames, &out.residuals.tables, &out.masks})
      if (!frames->empty()) frames->resize(to.lattice.dims[3]);
  }
}

// Bytes of masks that only frames from `frames` on have.
uint64_t Bcc4Writer::State::masks_beyond(uint32_t frames) const {
  std::set<uint64_t> known;
  uint64_t bytes = 0;
  const auto for_masks = [&](bool beyond, const auto& body) {
    for (const ChannelBlocks& c : blocks) {
      const size_t within = std::min<size_t>(frames, c.masks.size());
      for (size_t f = beyond ? within : 0; f < (beyond ? c.masks.size() : within); ++f)
        if (c.masks[f].stored > 0 && known.insert(c.masks[f].offset).second) body(c.masks[f]);
    }
  };
  for_masks(false, [](const BlockRef&) {});
  for_masks(true, [&](const BlockRef& mask) { bytes += mask.padded(); });
  return bytes;
}

// Appends directory and metadata and makes all that is written durable. beyond: bytes of blocks that the
// state does not refer to.
Root Bcc4Writer::State::append_state(const VolumeInfo& of, std::span<const PageRef> pages, uint64_t beyond) {
  replaced += std::exchange(shown_bytes, 0);
  Root root;
  root.directory = append_block(pack_block(write_directory(pages)));
  root.metadata = append_block(pack_block(write_metadata(of)));
  root.file_bytes = position;
  root.chunks = index->chunks(), root.runs_bytes = index->runs_bytes();
  root.values_bytes = index->values_bytes();
  root.index_bytes =
      position - unused - replaced - index->replaced_bytes() - beyond - root.runs_bytes - root.values_bytes;
  flush();
  sink->flush();
  return root;
}

void Bcc4Writer::State::show(VolumeInfo of, const Context& context) {
  Bcc4Report ignored;
  index->describe(of, ignored);
  take_blocks(of);
  tidy(of);
  check_info(of, Code::invalid_argument);
  context.progress.check();
  Root root = append_state(of, index->show_pages(), masks_beyond(of.lattice.dims[3]));
  shown_bytes = root.directory.padded() + root.metadata.padded();
  root.unfinished = true, root.frames = of.lattice.dims[3];
  root.sequence = ++shown;
  // The first root stands in A, those that follow overwrite the older one.
  if (shown == 1)
    sink->write_at(0, write_preamble({root, Root{}}, unfinished_version));
  else
    sink->write_at(root_offsets[(shown - 1) % 2], write_root(root));
  sink->flush();
}

Bcc4Report Bcc4Writer::State::finish(const Context& context) {
  index->check_ends(info);
  Bcc4Report report;
  const std::vector<PageRef> pages = index->finish_pages();
  index->describe(info, report);
  take_blocks(info);
  info.unfinished = false, info.expected_frames = 0;
  tidy(info);
  check_info(info, Code::invalid_argument);
  context.progress.check();

  const Root root = append_state(info, pages, 0);
  // Both roots say the same, so that the file survives damage to one of them.
  std::array<Root, 2> roots{root, root};
  for (size_t i = 0; i < 2; ++i) roots[(shown + i) % 2].sequence = shown + 1 + i;
  if (shown > 0) { // the older root first: there is a valid one at any moment
    sink->write_at(root_offsets[shown % 2], write_root(roots[shown % 2]));
    sink->flush();
  }
  sink->write_at(0, write_preamble(roots, lowest_reader(info)));
  sink->flush();
  sink->commit();
  if (options.journal) options.journal->remove();

  report.chunks = root.chunks;
  report.bytes_corrections = correction_bytes;
  report.slabs_reused = slabs_reused;
  report.bytes = {root.file_bytes, root.runs_bytes, root.values_bytes, root.index_bytes,
                  unused + replaced + index->replaced_bytes()};
  return report;
}

Bcc4Writer::Bcc4Writer(std::unique_ptr<ByteSink> sink, const VolumeInfo& initial,
                       const Bcc4WriterOptions& options)
    : state_(std::make_unique<State>(std::move(sink), initial, options)) {}

Bcc4Writer::~Bcc4Writer() { state_->keep(); }

VolumeInfo& Bcc4Writer::info() { return state_->info; }

void Bcc4Writer::write_slab(int32_t slab, const ChannelLevel& at, std::span<const SampleLayer> layers,
                            const Context& context) {
  State& s = *state_;
  if (s.closed) fail(Code::wrong_state, "writer: finished, or failed before");
  s.start();
  s.index->check_slab(slab, at, s.info);
  s.check_layers(slab, at, layers);
  s.closed = true;
  s.write_slab(slab, at, layers, context);
  s.closed = false;
}

void Bcc4Writer::write_slab(int32_t slab, const ChannelLevel& at, std::span<const BrickLayer> layers,
                            const Context& context) {
  write_slab(slab, at, std::vector<SampleLayer>(layers.begin(), layers.end()), context);
}

void Bcc4Writer::copy_slab(int32_t slab, const ChannelLevel& at, const Bcc4Reader& from) {
  State& s = *state_;
  if (s.closed) fail(Code::wrong_state, "writer: finished, or failed before");
  s.start();
  s.index->check_slab(slab, at, s.info);
  if (!same_coding(from.info(), s.info))
    fail(Code::invalid_argument, "writer: slab ", slab, " comes from a file of another lattice or coding");
  s.closed = true;
  static_cast<void>(s.copy_chunks(slab, at, from));
  s.index->enter_slab(slab, at, s.info.level(at.level).layers_of(slab), 0);
  s.closed = false;
}

ChannelBlocks& Bcc4Writer::State::blocks_of(int channel) {
  if (closed) fail(Code::wrong_state, "writer: finished, or failed before");
  start();
  if (channel < 0 || static_cast<size_t>(channel) >= blocks.size())
    fail(Code::invalid_argument, "writer: corrections or masks of channel ", channel, " of ", blocks.size());
  return blocks[static_cast<size_t>(channel)];
}

namespace {

void set_block(std::vector<BlockRef>& frames, uint32_t frame, const BlockRef& block) {
  if (frames.size() <= frame) frames.resize(size_t{frame} + 1);
  frames[frame] = block;
}

} // namespace

BlockRef Bcc4Writer::State::add_corrections(PackedBlock block) {
  correction_bytes += block.ref.padded();
  return append_block(std::move(block));
}

BlockRef Bcc4Writer::State::copy_block(const BlockRef& block, const Bcc4Reader& from) {
  const std::vector<std::byte> bytes = from.stored_block(block, "corrections");
  BlockRef copy = block;
  copy.offset = position;
  append(bytes);
  correction_bytes += copy.padded();
  return copy;
}

void Bcc4Writer::State::add_table(int channel, uint32_t frame, std::span<const CorrectionBrick> table) {
  ByteWriter out;
  write_correction_table(out, table);
  set_block(blocks[static_cast<size_t>(channel)].tables, frame, add_corrections(pack_block(out.bytes())));
}

// Plane of bricks by plane of bricks, those of a plane side by side.
void Bcc4Writer::State::write_corrections(int channel, uint32_t frame, std::span<const ResidualSample> list,
                                          const Context& context) {
  const double step = info.channels[static_cast<size_t>(channel)].residuals.step;
  const CorrectionBricks bricks(info.lattice.dims);
  std::vector<CorrectionBrick> table;
  while (!list.empty()) {
    const auto plane_end =
        std::ranges::lower_bound(list, bricks.plane_end(list.front().voxel), {}, &ResidualSample::voxel);
    const auto plane = list.first(static_cast<size_t>(plane_end - list.begin()));
    list = list.subspan(plane.size());
    const auto parts = bricks.split(plane, context.progress);
    std::vector<PackedBlock> blocks_of_plane(parts.size());
    context.tasks.parallel_for(parts.size(), [&](uint64_t i) {
      blocks_of_plane[i] = pack_block(bccsplat::write_corrections(parts[i].second), &context.progress);
    });
    for (size_t i = 0; i < parts.size(); ++i) {
      CorrectionBrick& entry = table.emplace_back();
      entry.brick = parts[i].first, entry.count = static_cast<uint32_t>(parts[i].second.size());
      const auto [low, high] = std::ranges::minmax(parts[i].second, {}, &ResidualSample::steps);
      entry.low = CorrectionBricks::value(low.steps, step);
      entry.high = CorrectionBricks::value(high.steps, step);
      entry.block = add_corrections(std::move(blocks_of_plane[i]));
    }
  }
  add_table(channel, frame, table);
}

void Bcc4Writer::write_residuals(int channel, uint32_t frame, const FrameResiduals& residuals,
                                 const Context& context) {
  State& s = *state_;
  if (residuals.empty()) return;
  ChannelBlocks& c = s.blocks_of(channel);
  s.closed = true;
  const bool local = s.info.channels[static_cast<size_t>(channel)].residuals.local;
  if (local && !residuals.add.empty()) s.write_corrections(channel, frame, residuals.add, context);
  const auto add_frame = [&](const FrameResiduals& r) {
    set_block(c.residuals, frame,
              s.add_corrections(pack_block(bccsplat::write_residuals(r), &context.progress)));
  };
  if (!local)
    add_frame(residuals);
  else if (!residuals.set.empty())
    add_frame({.add = {}, .set = residuals.set});
  s.closed = false;
}

// The bricks as they are, and a table that knows their new places.
void Bcc4Writer::State::copy_corrections(int channel, uint32_t frame, const Bcc4Reader& from) {
  std::vector<CorrectionBrick> table = from.correction_bricks(channel, frame);
  if (table.empty()) return;
  for (CorrectionBrick& brick : table) brick.block = copy_block(brick.block, from);
  add_table(channel, frame, table);
}

void Bcc4Writer::copy_residuals(int channel, uint32_t frame, const Bcc4Reader& from) {
  State& s = *state_;
  ChannelBlocks& c = s.blocks_of(channel);
  s.closed = true;
  s.copy_corrections(channel, frame, from);
  const auto& frames = from.info().channels[static_cast<size_t>(channel)].residuals.frames;
  if (frame < frames.size() && frames[frame].stored > 0)
    set_block(c.residuals, frame, s.copy_block(frames[frame], from));
  s.closed = false;
}

void Bcc4Writer::State::add_mask(int channel, uint32_t frame, PackedBlock block) {
  ChannelBlocks& c = blocks_of(channel);
  closed = true;
  std::optional<BlockRef> place = mask_blocks.find(block);
  if (!place) {
    block.ref.offset = position;
    append(block.bytes);
    place = block.ref;
    mask_blocks.add(std::move(block));
  }
  set_block(c.masks, frame, *place);
  closed = false;
}

void Bcc4Writer::write_mask(int channel, uint32_t frame, std::span<const std::byte> runs,
                            const Context& context) {
  if (!runs.empty()) state_->add_mask(channel, frame, pack_block(runs, &context.progress));
}

void Bcc4Writer::copy_mask(int channel, uint32_t frame, const Bcc4Reader& from) {
  const auto& masks = from.info().channels.at(static_cast<size_t>(channel)).masks;
  if (frame < masks.size() && masks[frame].stored > 0)
    state_->add_mask(channel, frame, {masks[frame], from.stored_block(masks[frame], "mask")});
}

int32_t Bcc4Writer::common_slabs() const {
  const State& s = *state_;
  return s.index ? s.index->common_slabs(s.info) : 0;
}

void Bcc4Writer::show(VolumeInfo info, const Context& context) {
  State& s = *state_;
  if (s.closed) fail(Code::wrong_state, "writer: finished, or failed before");
  s.start();
  s.closed = true;
  s.show(std::move(info), context);
  s.closed = false;
}

Bcc4Report Bcc4Writer::finish(const Context& context) {
  State& s = *state_;
  if (s.closed) fail(Code::wrong_state, "writer: finished, or failed before");
  s.start();
  s.closed = true;
  return s.finish(context);
}

} // namespace bccsplat
