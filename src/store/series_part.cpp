// SPDX-License-Identifier: Apache-2.0
// Works out which slabs, layers and frames a part or the rest of a series takes, from the reach of
// resampling, low-pass and measuring, so that each slab comes out as a writer of the whole series
// makes it.
#include "store/series_part.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "fit/beyond/ends.h"
#include "fit/resample/lowpass.h"
#include "store/measured_boxes.h"
#include "store/part_report.h"
#include "store/round_trip.h"

namespace bccsplat {
namespace {

void include(LayerSpan& all, const LayerSpan& more) {
  if (more.begin >= more.end) return;
  all = all.begin < all.end ? LayerSpan{std::min(all.begin, more.begin), std::max(all.end, more.end)} : more;
}

LayerSpan whole_slabs(const LayerSpan& span, int32_t slab_layers, int32_t layers) {
  if (span.begin >= span.end) return {};
  return {span.begin / slab_layers * slab_layers,
          std::min(layers, (span.end + slab_layers - 1) / slab_layers * slab_layers)};
}

// Frames on either side that a layer is resampled from.
int frame_reach(const Lattice4& lattice, const FitOptions& options, double widening) {
  return filter_reach(widening) + 1 + (options.lowpass ? lowpass_time_reach(lattice) : 0);
}

// Frames that layers are resampled from; frames beyond the ends depend on those next to them.
std::array<int64_t, 2> frames_of(const LayerSpan& layers, const Lattice4& lattice,
                                 const FitOptions& options) {
  const double widening = std::max(1.0, lattice.time_step / lattice.layer_distance());
  const int64_t frames = options.dims[3];
  const int reach = frame_reach(lattice, options, widening);
  int64_t first = static_cast<int64_t>(std::floor(lattice.layer_frame(layers.begin))) - reach;
  int64_t end = static_cast<int64_t>(std::ceil(lattice.layer_frame(layers.end - 1))) + reach + 1;
  if (end > frames)
    first = std::min(first, frames - 2 - reach - static_cast<int64_t>(std::ceil(lattice.time_step)));
  if (lattice.lead > 0) {
    const int64_t predicting =
        EndFrames::used(widening) + (options.lowpass ? lowpass_time_reach(lattice) : 0);
    if (end > frames) first = std::min(first, frames - predicting);
    if (first < 0) end = std::max(end, predicting);
  }
  return {std::clamp<int64_t>(first, 0, frames), std::clamp<int64_t>(end, 0, frames)};
}

// Sets the bricks of a part that may be a block. Where the field is measured, coefficients are made of those
// beside its own as well: no prefilter reaches further.
void set_bricks(const SeriesBlock& block, const Lattice4& lattice, bool measured, SeriesPart& part) {
  part.fit.bricks = layer_bricks_of(block, lattice);
  if (!measured || block.all_space()) return;
  part.measured = bricks_near(block, lattice, kernel_sites);
  const BrickBox all = part.fit.bricks.counted.joined(part.measured);
  part.fit.bricks.made = all.empty() ? all : all.widened();
}

} // namespace

LayerBricks layer_bricks_of(const SeriesBlock& block, const Lattice4& lattice) {
  const BrickBox own = bricks_of(block, lattice);
  return {own, own};
}

SeriesPart part_of_series(const Lattice4& lattice, const FitOptions& options, const MeasuredFrames& measured,
                          const SeriesBlock& block) {
  const uint32_t frames = options.dims[3], first = block.first_frame(), end = block.end_frame();
  if (first >= end || end > frames)
    fail(Code::invalid_argument, "a part of frames ", first, " to ", end, " (excluded): the series has ",
         frames, ", and a part has at least one");
  SeriesPart part;
  part.fit.counted = block;
  part.fit.first_given = first, part.fit.end_given = end;
  set_bricks(block, lattice, !measured.frames.empty(), part);
  if (lattice.is_static()) {
    part.end_slab = (lattice.layers() + options.slab_layers - 1) / options.slab_layers;
    part.fit.end_layer = part.fit.end_own = lattice.layers();
    return part;
  }
  const int32_t layers = lattice.layers(), slab = options.slab_layers;
  // The first slab at or after a frame.
  const auto slab_at = [&](uint32_t frame) {
    const int32_t slabs = (layers + slab - 1) / slab;
    if (frame == 0) return 0; // layers before it as well
    if (frame == frames) return slabs;
    auto s = static_cast<int32_t>(std::ceil(frame / (lattice.time_step * slab)));
    while (s > 0 && lattice.layer_frame((s - 1) * slab) >= frame) --s;
    while (s < slabs && lattice.layer_frame(s * slab) < frame) ++s;
    return s;
  };
  part.first_slab = slab_at(first), part.end_slab = slab_at(end);
  const LayerSpan own{std::min(part.first_slab * slab, layers), std::min(part.end_slab * slab, layers)};
  LayerSpan made = own;
  for (const uint32_t frame : measured.frames)
    if (frame >= first && frame < end) include(made, layers_to_measure(lattice, measured.kernel, frame));
  made = whole_slabs(made, slab, layers);
  if (made.begin < made.end) {
    const auto [from, to] = frames_of(made, lattice, options);
    part.fit.first_given = std::min(first, static_cast<uint32_t>(from));
    part.fit.end_given = std::max(end, static_cast<uint32_t>(to));
  }
  part.fit.first_layer = made.begin, part.fit.end_layer = made.end;
  part.fit.first_own = own.begin, part.fit.end_own = own.end;
  return part;
}

int32_t lasting_slabs(const Lattice4& lattice, const FitOptions& options, uint32_t frames) {
  if (lattice.is_static() || lattice.periodic) return 0;
  const double widening = std::max(1.0, lattice.time_step / lattice.layer_distance());
  // With fewer, what stands before the first frame changes as well.
  if (lattice.lead > 0 &&
      frames < EndFrames::used(widening) + (options.lowpass ? lowpass_time_reach(lattice) : 0))
    return 0;
  const double last = frames - 1.0 - frame_reach(lattice, options, widening);
  int32_t layers = 0;
  while (lattice.layer_frame(layers) <= last) ++layers;
  return layers / options.slab_layers;
}

SeriesPart rest_of_series(const Lattice4& lattice, const FitOptions& options, uint32_t done) {
  const uint32_t frames = options.dims[3];
  SeriesPart part;
  part.first_slab = lasting_slabs(lattice, options, done);
  const LayerSpan made{part.first_slab * options.slab_layers, lattice.layers()};
  part.end_slab = (made.end + options.slab_layers - 1) / options.slab_layers;
  part.fit.counted = SeriesBlock::of_frames(done, frames), part.fit.end_given = frames;
  part.fit.first_layer = part.fit.first_own = made.begin;
  part.fit.end_layer = part.fit.end_own = made.end;
  if (made.begin > 0) part.fit.first_given = static_cast<uint32_t>(frames_of(made, lattice, options)[0]);
  part.fit.first_given = std::min(part.fit.first_given, done);
  return part;
}

void begin_earlier(uint64_t frames, FitPart& part) {
  if (frames > part.first_given)
    fail(Code::invalid_argument, "part.lead ", frames, ": only ", part.first_given,
         " frames come before the first one needed");
  part.first_given -= static_cast<uint32_t>(frames);
}

namespace {

// Returns what `channels` counted of the slabs that last, and nothing else.
std::vector<std::byte> lasting_counts(int32_t lasting, std::span<const FitChannelReport> channels) {
  PartReport report;
  report.lasting = lasting;
  for (const FitChannelReport& c : channels) report.channels.emplace_back().fit.lasting = c.lasting;
  return write_part_report(report);
}

} // namespace

void describe_tail(int32_t lasting, std::span<const FitChannelReport> channels, VolumeInfo& info) {
  info.tail.reset(), info.counts.reset();
  if (info.tile_edge > 1) {
    if (lasting > 0) info.counts = {lasting, lasting_counts(lasting, channels)};
    return;
  }
  TailInfo tail{lasting, {}};
  uint64_t all = 0;
  for (const FitChannelReport& c : channels) {
    const size_t n = std::min(static_cast<size_t>(lasting), c.clamped_slabs.size());
    uint64_t sum = 0;
    for (const uint64_t slab : std::span(c.clamped_slabs).first(n)) sum += slab;
    tail.clamped.push_back(sum);
    all += c.clamped;
  }
  if (all > 0) info.tail = std::move(tail);
}

} // namespace bccsplat
