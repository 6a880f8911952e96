// SPDX-License-Identifier: Apache-2.0
// Goes through the motions of cutting a slice with samples that only note what is asked of them, and looks up
// where that stands in the file.
#include "volume/read_ranges.h"

#include <algorithm>
#include <cmath>

#include "base/would_block.h"
#include "formats/bcc4/recorded_reads.h"
#include "slice/masked_slice.h"

namespace bccsplat {
namespace {

// Asks for all that a slice takes; returns the moments whose masks and corrections it looks at.
std::optional<SliceMoments> rehearse(const Coefficients& coefficients, const SliceRequest& asked,
                                     const Context& context) {
  if (!asked.extracted) return rehearse_hyperslice(coefficients, asked.plane, asked.cut, context);
  const Slice plane = bare_plane(coefficients, asked.plane, extraction_options(asked.cut), {});
  (void)Extraction(coefficients.samples(), coefficients.channel(), asked.plane,
                   PlaneAxes{plane.origin, plane.basis}, context);
  if (plane.empty()) return std::nullopt;
  return SliceMoments{moments_of(plane), {0, -1}}; // extracted points have no corrections
}

void list_masks(const Masks& masks, const std::array<double, 2>& moments, bool missing,
                std::vector<ByteRange>& out) {
  masks.list_reads(masks.counted_frame(moments[0]), masks.counted_frame(moments[1]), missing, out);
}

void list_corrections(const Corrections& corrections, const Lattice4& lattice,
                      const std::array<double, 2>& moments, bool missing, std::vector<ByteRange>& out) {
  const int64_t frames = corrections.samples()[3];
  auto first = static_cast<int64_t>(std::floor(moments[0])),
       last = static_cast<int64_t>(std::ceil(moments[1]));
  if (!lattice.periodic) first = std::max<int64_t>(first, 0), last = std::min(last, frames - 1);
  last = std::min(last, first + frames - 1);
  Attempts attempts;
  for (int64_t f = first; f <= last; ++f)
    attempts.attempt([&] { corrections.list_reads(lattice.turned_frame(f), missing, out); });
  attempts.throw_if_waiting();
}

} // namespace

std::vector<ByteRange> read_ranges(const OpenVolume& volume, const SliceRequest& asked, const char* kernel,
                                   bool missing, const Context& context) {
  const Lattice4& lattice = volume.lattice(asked.level);
  const RecordedReads reads(volume.samples(asked.level));
  const auto coefficients =
      volume.rehearsal(asked.channel, kernel, asked.level, asked.cut.reads(lattice), reads, missing);
  const auto moments = rehearse(*coefficients, asked, context);
  std::vector<ByteRange> ranges;
  Attempts attempts;
  attempts.attempt([&] { reads.list(missing, ranges); });
  if (const Masks* masks = coefficients->masks(); masks && moments)
    list_masks(*masks, moments->masks, missing, ranges);
  if (const Corrections* fix = coefficients->corrections(); fix && moments)
    attempts.attempt([&] { list_corrections(*fix, lattice, moments->corrections, missing, ranges); });
  attempts.throw_if_waiting();
  merge_ranges(ranges, volume.reader()->merge_gap());
  return ranges;
}

} // namespace bccsplat
