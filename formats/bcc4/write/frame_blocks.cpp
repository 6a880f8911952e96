// SPDX-License-Identifier: Apache-2.0
// Writes or copies the blocks of source frames: corrections of a frame as a whole or brick by brick with a
// table of the bricks, and masks, which frames share.
#include "formats/bcc4/write/frame_blocks.h"

#include <algorithm>
#include <optional>
#include <set>
#include <utility>

namespace bccsplat {
namespace {

void set_block(std::vector<BlockRef>& frames, uint32_t frame, const BlockRef& block) {
  if (frames.size() <= frame) frames.resize(size_t{frame} + 1);
  frames[frame] = block;
}

// Returns an entry without its block.
CorrectionBrick brick_entry(uint32_t brick, std::span<const ResidualSample> samples, double step) {
  const auto [low, high] = std::ranges::minmax(samples, {}, &ResidualSample::steps);
  CorrectionBrick entry;
  entry.brick = brick, entry.count = static_cast<uint32_t>(samples.size());
  entry.low = correction_value(low.steps, step);
  entry.high = correction_value(high.steps, step);
  return entry;
}

} // namespace

BlockRef FrameBlocks::append_corrections(const PackedBlock& block) {
  correction_bytes_ += block.ref.padded();
  return file_.append(block);
}

void FrameBlocks::append_table(int channel, uint32_t frame, std::span<const CorrectionBrick> table) {
  ByteWriter out;
  write_correction_table(out, table);
  // Sums are added to: a frame's corrections are written once.
  for (const CorrectionBrick& brick : table) at(channel).sums_of(frame).corrections += brick.count;
  set_block(at(channel).tables, frame, append_corrections(pack_block(out.bytes())));
}

// Writes plane of bricks by plane of bricks; those of a plane are packed side by side.
void FrameBlocks::write_bricks(const VolumeInfo& info, int channel, uint32_t frame,
                               std::span<const ResidualSample> list, const Context& context) {
  const double step = info.channels[channel].residuals.step;
  const CorrectionBricks bricks(info.lattice.dims);
  std::vector<CorrectionBrick> table;
  while (!list.empty()) {
    const auto plane_end = std::ranges::lower_bound(list, brick_plane_end(bricks, list.front().voxel), {},
                                                    &ResidualSample::voxel);
    const auto plane = list.first(plane_end - list.begin());
    list = list.subspan(plane.size());
    const auto parts = split_corrections(bricks, plane, context.progress);
    std::vector<PackedBlock> blocks(parts.size());
    context.tasks.parallel_for(parts.size(), [&](uint64_t i) {
      blocks[i] = pack_block(bccsplat::write_corrections(parts[i].second), &context.progress);
    });
    for (size_t i = 0; i < parts.size(); ++i) {
      CorrectionBrick& entry = table.emplace_back(brick_entry(parts[i].first, parts[i].second, step));
      entry.block = append_corrections(blocks[i]);
    }
  }
  append_table(channel, frame, table);
}

void FrameBlocks::write_corrections(const VolumeInfo& info, int channel, uint32_t frame,
                                    const FrameResiduals& residuals, const Context& context) {
  const bool local = info.channels[channel].residuals.local;
  if (local && !residuals.add.empty()) write_bricks(info, channel, frame, residuals.add, context);
  const auto write_whole = [&](const FrameResiduals& whole) {
    const PackedBlock block = pack_block(write_residuals(whole), &context.progress);
    at(channel).sums_of(frame).corrections += whole.add.size() + whole.set.size();
    set_block(at(channel).residuals, frame, append_corrections(block));
  };
  if (!local)
    write_whole(residuals);
  else if (!residuals.set.empty())
    write_whole({.add = {}, .set = residuals.set});
}

namespace {

// A brick as one file has it.
struct FileBrick {
  CorrectionBrick entry;
  const Bcc4Reader* file;
};

PackedBlock stored_corrections(const BlockRef& block, const Bcc4Reader& file) {
  return {block, file.stored_block(block, "corrections")};
}

// Returns the bricks of all files, by number.
std::vector<FileBrick> bricks_of(int channel, uint32_t frame, std::span<const Bcc4Reader* const> files) {
  std::vector<FileBrick> bricks;
  for (const Bcc4Reader* file : files)
    for (const CorrectionBrick& entry : file->correction_bricks(channel, frame))
      bricks.push_back({entry, file});
  std::ranges::stable_sort(bricks, {}, [](const FileBrick& b) { return b.entry.brick; });
  return bricks;
}

// Returns what files have of one brick.
ResidualList joined_list(int channel, std::span<const FileBrick> bricks) {
  ResidualList all;
  for (const FileBrick& b : bricks) {
    const ResidualList list = b.file->corrections(channel, b.entry);
    all.insert(all.end(), list.begin(), list.end());
  }
  std::ranges::sort(all, {}, &ResidualSample::voxel);
  if (std::ranges::adjacent_find(all, {}, &ResidualSample::voxel) != all.end())
    fail(Code::invalid_argument, "two parts correct the same sample of a frame");
  return all;
}

} // namespace

void FrameBlocks::copy_corrections(const VolumeInfo& info, int channel, uint32_t frame,
                                   std::span<const Bcc4Reader* const> from, const Context& context) {
  constexpr size_t at_once = 64; // bricks that are held
  const double step = info.channels[channel].residuals.step;
  const std::vector<FileBrick> bricks = bricks_of(channel, frame, from);
  std::vector<std::span<const FileBrick>> groups; // of one brick each
  for (size_t i = 0; i < bricks.size();) {
    size_t end = i + 1;
    while (end < bricks.size() && bricks[end].entry.brick == bricks[i].entry.brick) ++end;
    groups.push_back(std::span(bricks).subspan(i, end - i));
    i = end;
  }
  std::vector<CorrectionBrick> table(groups.size());
  for (size_t first = 0; first < groups.size(); first += at_once) {
    std::vector<PackedBlock> blocks(std::min(at_once, groups.size() - first));
    context.tasks.parallel_for(blocks.size(), [&](uint64_t i) {
      context.progress.check();
      const std::span<const FileBrick> group = groups[first + i];
      CorrectionBrick& entry = table[first + i] = group.front().entry;
      if (group.size() == 1) {
        blocks[i] = stored_corrections(entry.block, *group.front().file);
        return;
      }
      const ResidualList list = joined_list(channel, group);
      entry = brick_entry(entry.brick, list, step);
      blocks[i] = pack_block(bccsplat::write_corrections(list), &context.progress);
    });
    for (size_t i = 0; i < blocks.size(); ++i) table[first + i].block = append_corrections(blocks[i]);
  }
  if (!table.empty()) append_table(channel, frame, table);
  copy_whole(channel, frame, from);
}

// Blocks of space have no holes of the lattice.
void FrameBlocks::copy_whole(int channel, uint32_t frame, std::span<const Bcc4Reader* const> from) {
  bool copied = false;
  for (const Bcc4Reader* file : from) {
    const auto& frames = file->info().channels[channel].residuals.frames;
    if (frame >= frames.size() || frames[frame].stored == 0) continue;
    if (std::exchange(copied, true))
      fail(Code::unsupported, "corrections in holes of the lattice are in several parts of frame ", frame);
    const FrameResiduals whole = file->residuals(channel, frame);
    at(channel).sums_of(frame).corrections += whole.add.size() + whole.set.size();
    set_block(at(channel).residuals, frame, append_corrections(stored_corrections(frames[frame], *file)));
  }
}

void FrameBlocks::add_mask(int channel, uint32_t frame, PackedBlock block, uint64_t missing) {
  std::optional<BlockRef> place = masks_.find(block);
  if (!place) {
    place = block.ref = file_.append(block);
    masks_.add(std::move(block));
  }
  set_block(at(channel).masks, frame, *place);
  at(channel).sums_of(frame).missing = missing;
}

void FrameBlocks::describe(VolumeInfo& to) const {
  bool any = false;
  for (size_t i = 0; i < channels_.size(); ++i) {
    ChannelInfo& out = to.channels[i];
    out.residuals.frames = channels_[i].residuals, out.residuals.tables = channels_[i].tables;
    out.masks = channels_[i].masks;
    for (auto* frames : {&out.residuals.frames, &out.residuals.tables, &out.masks})
      if (!frames->empty()) frames->resize(to.lattice.dims[3]), any = true;
  }
  for (size_t i = 0; i < channels_.size(); ++i) {
    std::optional<FrameSums>& sums = to.channels[i].sums;
    sums = any ? std::optional(FrameSums{}) : std::nullopt;
    for (size_t f = 0; any && f < std::min<size_t>(to.lattice.dims[3], channels_[i].sums.size()); ++f)
      sums->corrections += channels_[i].sums[f].corrections, sums->missing += channels_[i].sums[f].missing;
  }
}

uint64_t FrameBlocks::masks_beyond(uint32_t frames) const {
  std::set<uint64_t> known; // offsets
  for (const Channel& c : channels_)
    for (size_t f = 0; f < std::min<size_t>(frames, c.masks.size()); ++f) known.insert(c.masks[f].offset);
  uint64_t bytes = 0;
  for (const Channel& c : channels_)
    for (size_t f = frames; f < c.masks.size(); ++f)
      if (c.masks[f].stored > 0 && known.insert(c.masks[f].offset).second) bytes += c.masks[f].padded();
  return bytes;
}

} // namespace bccsplat
