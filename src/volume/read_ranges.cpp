// SPDX-License-Identifier: Apache-2.0
// Looks up where in the file that stands what a plan asks for.
#include "volume/read_ranges.h"

#include <algorithm>
#include <cmath>

#include "volume/labels.h"

namespace bccsplat {
namespace {

using Ranges = std::vector<ByteRange>;

void list_chunks(const Bcc4Samples& samples, const CutPlan& plan, bool missing, Attempts& attempts,
                 Ranges& out, const Context& context) {
  LayerReads reads, listed;
  list_layers(plan, missing, reads);
  const int32_t slab_layers = samples.reader().info().level(samples.level()).slab_layers;
  // Salvaging looks at what lies beside a layer, too, and layers of a chunk may be missing one by one.
  const bool by_slabs = !missing && !samples.reader().salvages();
  for (LayerRead r : reads) {
    context.progress.check();
    if (by_slabs) r.layer -= r.layer % slab_layers; // whose layers stand in the same chunks
    if (listed.insert(r).second)
      attempts.attempt(
          [&] { samples.list_reads(plan.coefficients->channel(), r.layer, r.bricks, missing, out); });
  }
}

void list_masks(const CutPlan& plan, bool missing, Ranges& out) {
  if (const Masks* masks = plan.coefficients->masks())
    masks->list_reads(masks->counted_frame(plan.masks[0]), masks->counted_frame(plan.masks[1]), missing, out);
}

void list_corrections(const CutPlan& plan, bool missing, Attempts& attempts, Ranges& out) {
  const Corrections* const fix = plan.coefficients->corrections();
  if (!fix) return;
  const Lattice4& lattice = plan.coefficients->source().lattice();
  const int64_t frames = fix->samples()[3];
  auto first = static_cast<int64_t>(std::floor(plan.corrections[0])),
       last = static_cast<int64_t>(std::ceil(plan.corrections[1]));
  if (!lattice.periodic) first = std::max<int64_t>(first, 0), last = std::min(last, frames - 1);
  last = std::min(last, first + frames - 1);
  for (int64_t f = first; f <= last; ++f)
    attempts.attempt([&] { fix->list_reads(lattice.turned_frame(f), missing, plan.corrected, out); });
}

} // namespace

std::vector<ByteRange> read_ranges(const OpenVolume& volume, const SliceRequest& asked, bool missing,
                                   const Context& context) {
  const SliceRequest made = as_cut(volume, asked);
  Ranges ranges;
  Attempts attempts;
  for (const CutPlan& plan : plans_of(volume, made)) {
    list_chunks(volume.samples(asked.level), plan, missing, attempts, ranges, context);
    if (!plan.empty) list_masks(plan, missing, ranges), list_corrections(plan, missing, attempts, ranges);
  }
  attempts.throw_if_waiting();
  merge_ranges(ranges, volume.reader()->merge_gap());
  return ranges;
}

void tell_lacking(const OpenVolume& volume, uint32_t level, std::span<const CutPlan> plans,
                  const WouldBlock& first, const Context& context) {
  constexpr uint64_t at_once = 256 << 10; // bytes, of which each may be late
  Attempts attempts;
  attempts.add(first);
  Ranges ranges;
  const auto list_lacking = [&](const CutPlan& plan) {
    list_chunks(volume.samples(level), plan, true, attempts, ranges, context);
    if (plan.empty) return;
    list_masks(plan, true, ranges);
    // What is compared with the field looks at corrections around points, and has told of those.
    if (plan.way == CutPlan::Way::time) list_corrections(plan, true, attempts, ranges);
  };
  for (const CutPlan& plan : plans) {
    if (plan.instants.empty()) list_lacking(plan);
    for (const double at : plan.instants) list_lacking(plan.instant(at));
  }
  merge_ranges(ranges, volume.reader()->merge_gap());
  for (const ByteRange& r : ranges)
    for (uint64_t done = 0; done < r.size; done += at_once) {
      context.progress.check();
      attempts.attempt([&] {
        volume.reader()->try_read({r.offset + done, std::min(at_once, r.size - done)});
      });
    }
  attempts.throw_if_waiting();
  throw first; // never reached
}

} // namespace bccsplat
