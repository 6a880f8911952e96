// SPDX-License-Identifier: Apache-2.0
#include "formats/bcc4/read/frame_sources.h"

#include "formats/bcc4/correction_table.h"

namespace bccsplat {

std::optional<ByteRange> Bcc4Masks::place(int64_t frame) const {
  const BlockRef& block = reader_->info().channels[channel_].masks[frame];
  return block.stored == 0 ? std::nullopt : std::optional(block.range());
}

std::optional<uint64_t> Bcc4Masks::told_count() const {
  const auto& sums = reader_->info().channels[channel_].sums;
  return sums ? std::optional(sums->missing) : std::nullopt;
}

void Bcc4Masks::read_runs(int64_t frame, const MaskRunBody& body) const {
  reader_->mask_runs(channel_, frame, body);
}

std::vector<GridValue> Bcc4Corrections::values(const ResidualList& list, int64_t nx, int64_t ny,
                                               float from) const {
  std::vector<GridValue> made;
  made.reserve(list.size());
  for (const ResidualSample& s : list) {
    const int64_t v = s.voxel;
    made.push_back({{static_cast<int32_t>(v % nx), static_cast<int32_t>(v / nx % ny),
                     static_cast<int32_t>(v / (nx * ny))},
                    from + correction_value(s.steps, step())});
  }
  return made;
}

std::optional<uint64_t> Bcc4Corrections::told_count() const {
  const auto& sums = reader_->info().channels[channel_].sums;
  return sums ? std::optional(sums->corrections) : std::nullopt;
}

CorrectionSource::Frame Bcc4Corrections::read_frame(int64_t frame) const {
  Frame made;
  made.table = reader_->correction_bricks(channel_, frame);
  const FrameResiduals stored = reader_->residuals(channel_, frame);
  const auto& n = lattice().dims;
  made.add = values(stored.add, n[0], n[1], 0);
  made.set = values(stored.set, n[0], n[1], reader_->info().channels[channel_].air);
  return made;
}

std::vector<GridValue> Bcc4Corrections::read_brick(const CorrectionBrick& brick) const {
  return values(reader_->corrections(channel_, brick), correction_edge, correction_edge, 0);
}

std::vector<ByteRange> Bcc4Corrections::places(int64_t frame) const {
  std::vector<ByteRange> made;
  const size_t f = frame;
  for (const std::vector<BlockRef>* blocks : {&info().frames, &info().tables})
    if (f < blocks->size()) made.push_back((*blocks)[f].range());
  return made;
}

} // namespace bccsplat
