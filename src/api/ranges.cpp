// SPDX-License-Identifier: Apache-2.0
// Tells which bytes a slice reads: goes through the motions of cutting it with samples that only note what is
// asked of them, and looks up where that stands.
#include <algorithm>
#include <cmath>

#include "api/handles.h"
#include "api/slice_options.h"
#include "api/structs.h"
#include "base/would_block.h"
#include "field/corrections.h"
#include "field/masks.h"
#include "formats/bcc4/recorded_reads.h"
#include "slice/masked_slice.h"

using namespace bccsplat;
using namespace bccsplat::api;

namespace {

// Asks for all that a slice takes; returns the moments whose masks and corrections it looks at.
std::optional<SliceMoments> rehearse(const Coefficients& coefficients, const Hyperplane& h,
                                     const HypersliceOptions& cut, int32_t method, const Context& context) {
  if (method != BCCSPLAT_METHOD_EXTRACTED) return rehearse_hyperslice(coefficients, h, cut, context);
  const Slice plane = bare_plane(coefficients, h, extraction_options(cut), {});
  (void)Extraction(coefficients.samples(), coefficients.channel(), h, PlaneAxes{plane.origin, plane.basis},
                   context);
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

std::vector<ByteRange> ranges_of(const bccsplat_volume& volume, const Hyperplane& h,
                                 const HypersliceOptions& cut, const bccsplat_slice_options& o, bool missing,
                                 const Context& context) {
  const Lattice4& lattice = volume.lattice(o.level);
  const RecordedReads reads(*volume.samples[o.level]);
  const auto coefficients =
      volume.rehearsal(o.channel, o.kernel, o.level, cut.reads(lattice), reads, missing);
  const auto moments = rehearse(*coefficients, h, cut, o.method, context);
  std::vector<ByteRange> ranges;
  Attempts attempts;
  attempts.attempt([&] { reads.list(missing, ranges); });
  if (const Masks* masks = coefficients->masks(); masks && moments)
    list_masks(*masks, moments->masks, missing, ranges);
  if (const Corrections* fix = coefficients->corrections(); fix && moments)
    attempts.attempt([&] { list_corrections(*fix, lattice, moments->corrections, missing, ranges); });
  attempts.throw_if_waiting();
  merge_ranges(ranges, volume.reader->merge_gap());
  return ranges;
}

} // namespace

extern "C" bccsplat_status bccsplat_volume_get_ranges(const bccsplat_volume* volume,
                                                      const bccsplat_hyperplane* hyperplane,
                                                      const bccsplat_slice_options* options, uint32_t flags,
                                                      uint64_t* ranges, uint64_t capacity, uint64_t* count) {
  return guard([&] {
    require(volume, "volume");
    if (capacity > 0) require(ranges, "ranges");
    if (flags & ~uint32_t{BCCSPLAT_RANGES_MISSING})
      fail(Code::invalid_argument, "get_ranges: unknown flags ", flags & ~uint32_t{BCCSPLAT_RANGES_MISSING});
    const auto o = read_struct(options, "bccsplat_slice_options");
    HypersliceOptions cut = read_slice_options(o, volume->info());
    const Hyperplane h = read_hyperplane(hyperplane, o, cut);
    const Token token = read_token(o.cancel_token);
    Progress progress(progress_callback(o.progress, o.progress_user), true);
    watch(progress, token), watch(progress, volume->token);
    progress.throw_if_cancelled();
    Progress unheard(progress, 0, 0); // its parts take no time that is worth telling
    const auto found = ranges_of(*volume, h, cut, o, (flags & BCCSPLAT_RANGES_MISSING) != 0,
                                 volume->device->context(unheard));
    progress.report(1);
    for (size_t i = 0; i < std::min<uint64_t>(capacity, found.size()); ++i)
      ranges[2 * i] = found[i].offset, ranges[2 * i + 1] = found[i].size;
    if (count) *count = found.size();
  });
}
