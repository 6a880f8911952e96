// SPDX-License-Identifier: Apache-2.0
// Writes or copies the blocks of source frames: corrections of a frame as a whole or brick by brick with a
// table of the bricks, and masks, which frames share.
#include "formats/bcc4/frame_blocks.h"

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

BlockRef FrameBlocks::copy_block(const BlockRef& block, const Bcc4Reader& from) {
  return append_corrections({block, from.stored_block(block, "corrections")});
}

void FrameBlocks::append_table(int channel, uint32_t frame, std::span<const CorrectionBrick> table) {
  ByteWriter out;
  write_correction_table(out, table);
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
    set_block(at(channel).residuals, frame, append_corrections(block));
  };
  if (!local)
    write_whole(residuals);
  else if (!residuals.set.empty())
    write_whole({.add = {}, .set = residuals.set});
}

void FrameBlocks::copy_corrections(int channel, uint32_t frame, const Bcc4Reader& from) {
  std::vector<CorrectionBrick> table = from.correction_bricks(channel, frame);
  for (CorrectionBrick& brick : table) brick.block = copy_block(brick.block, from);
  if (!table.empty()) append_table(channel, frame, table);
  const auto& frames = from.info().channels[channel].residuals.frames;
  if (frame < frames.size() && frames[frame].stored > 0)
    set_block(at(channel).residuals, frame, copy_block(frames[frame], from));
}

void FrameBlocks::add_mask(int channel, uint32_t frame, PackedBlock block) {
  std::optional<BlockRef> place = masks_.find(block);
  if (!place) {
    place = block.ref = file_.append(block);
    masks_.add(std::move(block));
  }
  set_block(at(channel).masks, frame, *place);
}

void FrameBlocks::describe(VolumeInfo& to) const {
  for (size_t i = 0; i < channels_.size(); ++i) {
    ChannelInfo& out = to.channels[i];
    out.residuals.frames = channels_[i].residuals, out.residuals.tables = channels_[i].tables;
    out.masks = channels_[i].masks;
    for (auto* frames : {&out.residuals.frames, &out.residuals.tables, &out.masks})
      if (!frames->empty()) frames->resize(to.lattice.dims[3]);
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
