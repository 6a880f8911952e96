// SPDX-License-Identifier: Apache-2.0
// Reads what a file has of source frames beside chunks: corrections and masks.
#include "formats/bcc4/coding/deflate.h"
#include "formats/bcc4/counts.h"
#include "formats/bcc4/read/reader_state.h"

namespace bccsplat {
namespace {

// The block of a frame; null where it has none.
const BlockRef* block_of(const std::vector<BlockRef>& frames, uint64_t frame) {
  return frame < frames.size() && frames[frame].stored > 0 ? &frames[frame] : nullptr;
}

} // namespace

FrameResiduals Bcc4Reader::State::residuals(int channel, uint64_t frame) const {
  const ResidualInfo& fix = info.channels.at(channel).residuals;
  const BlockRef* ref = block_of(fix.frames, frame);
  if (!ref) return {};
  const auto& n = info.lattice.dims;
  const uint64_t samples = uint64_t{n[0]} * n[1] * n[2];
  check_block_ref(*ref, "corrections", root.file_bytes, most_correction_bytes(samples));
  FrameResiduals all = read_residuals(read_block(*ref, "corrections"), samples, ref->offset);
  if (fix.local && !all.add.empty())
    fail(Code::corrupt, "corrections at offset ", ref->offset, ": some to add, which stand in bricks");
  return all;
}

std::vector<CorrectionBrick> Bcc4Reader::State::correction_bricks(int channel, uint64_t frame) const {
  const BlockRef* ref = block_of(info.channels.at(channel).residuals.tables, frame);
  if (!ref) return {};
  const CorrectionBricks bricks(info.lattice.dims);
  check_block_ref(*ref, "table of corrections", root.file_bytes, most_table_bytes(bricks.count()));
  return read_correction_table(read_block(*ref, "table of corrections"), bricks, ref->offset,
                               root.file_bytes);
}

ResidualList Bcc4Reader::State::corrections(int channel, const CorrectionBrick& brick) const {
  constexpr uint64_t edge = correction_edge;
  check_block_ref(brick.block, "corrections", root.file_bytes, most_correction_bytes(brick.count));
  ResidualList list =
      read_corrections(read_block(brick.block, "corrections"), edge * edge * edge, brick.block.offset);
  check_corrections(CorrectionBricks(info.lattice.dims), brick, list,
                    info.channels.at(channel).residuals.step);
  return list;
}

namespace {

// Returns what read() returns; nothing where it fails on what a salvaged file goes without.
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
  const BlockRef* ref = block_of(info().channels.at(channel).masks, frame);
  if (!ref) return;
  const auto& n = info().lattice.dims;
  const uint64_t samples = uint64_t{n[0]} * n[1] * n[2];
  state_->in_file([&] {
    check_block_ref(*ref, "mask", state_->root.file_bytes, most_run_bytes(samples));
    read_mask_runs(state_->read_block(*ref, "mask"), samples, ref->offset, body);
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

} // namespace bccsplat
