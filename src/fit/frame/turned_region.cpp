// SPDX-License-Identifier: Apache-2.0
#include "fit/frame/turned_region.h"

#include <algorithm>

namespace bccsplat {
namespace {

// Samples begin .. end - 1 of an axis, `shift` further on in a region.
struct Stretch {
  int64_t begin, end, shift;
};

std::vector<Stretch> stretches(int64_t begin, int64_t end, int64_t n, bool turns) {
  if (!turns) return {{std::max<int64_t>(begin, 0), std::min(end, n), 0}};
  std::vector<Stretch> found;
  for (int64_t at = begin; at < end;) {
    const int64_t sample = ((at % n) + n) % n, length = std::min(end - at, n - sample);
    found.push_back({sample, sample + length, at - sample});
    at += length;
  }
  return found;
}

} // namespace

std::vector<RegionPiece> region_pieces(const Region& region, const std::array<int64_t, 3>& n,
                                       const AxisFlags& turning) {
  std::array<std::vector<Stretch>, 3> along;
  for (size_t a = 0; a < 3; ++a) along[a] = stretches(region.begin[a], region.end[a], n[a], turning[a]);
  std::vector<RegionPiece> pieces;
  for (const Stretch& z : along[2])
    for (const Stretch& y : along[1])
      for (const Stretch& x : along[0])
        pieces.push_back({{{x.begin, y.begin, z.begin}, {x.end, y.end, z.end}}, {x.shift, y.shift, z.shift}});
  return pieces;
}

CellRanges::Cell turned_range(const CellRanges& cells, const Region& region, const std::array<int64_t, 3>& n,
                              const AxisFlags& turning) {
  CellRanges::Cell all;
  for (const RegionPiece& piece : region_pieces(region, n, turning)) {
    const CellRanges::Cell range = cells.range(piece.samples);
    all.low = std::min(all.low, range.low), all.high = std::max(all.high, range.high);
    all.broken = all.broken || range.broken;
  }
  return all;
}

TurnedFrame::TurnedFrame(const Frame& frame, const Region& region, const AxisFlags& turning)
    : frame_(frame), pieces_(region_pieces(region, frame.dims(), turning)) {
  for (const RegionPiece& piece : pieces_) boxes_.push_back(frame.boxes_in(piece.samples));
}

size_t TurnedFrame::boxes() const {
  size_t most = 0;
  for (const auto& list : boxes_) most = std::max(most, list.size());
  return most;
}

void TurnedFrame::read(const Region& part, float* out, int64_t row, int64_t plane) const {
  for (size_t p = 0; p < pieces_.size(); ++p) {
    const RegionPiece& piece = pieces_[p];
    Region wanted = part;
    for (size_t a = 0; a < 3; ++a) wanted.begin[a] -= piece.shift[a], wanted.end[a] -= piece.shift[a];
    wanted = wanted.cut(piece.samples);
    if (wanted.empty()) continue;
    const auto from = [&](size_t a) { return wanted.begin[a] + piece.shift[a] - part.begin[a]; };
    frame_.read(boxes_[p], wanted, out + from(2) * plane + from(1) * row + from(0), row, plane);
  }
}

} // namespace bccsplat
