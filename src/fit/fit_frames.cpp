// SPDX-License-Identifier: Apache-2.0
// Frames and layers on their way in: refuses what cannot come next, counts, clamps or fills what is missing,
// low-passes, and resamples to the sites of the lattice.
#include <algorithm>
#include <cfloat>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "base/sizes.h"
#include "fit/fit_state.h"

namespace bccsplat {
namespace {

// Largest departure from air: filters and prefilters multiply it by up to some hundred in 32-bit floats.
constexpr double largest_value = 1e36;

} // namespace

void Fit::State::Channel::check_range(double low, double high, const std::string& what) const {
  const double air = options.quantiser.air;
  if (low - air < -largest_value || high - air > largest_value)
    fail(Code::limit_exceeded, what, ": its values reach from ", low, " to ", high, ", further than ",
         largest_value,
         " from air, where filters in 32-bit floats overflow; declare fill values missing, or scale the "
         "values");
}

void Fit::State::Channel::note_range(double low, double high) {
  report.source_range.low = report.any_finite ? std::min(report.source_range.low, low) : low;
  report.source_range.high = report.any_finite ? std::max(report.source_range.high, high) : high;
  report.any_finite = true;
}

std::array<float, 2> Fit::State::clamp_range(const Channel& c) const {
  if (!c.options.range && !c.report.any_finite) return {0, 0};
  const Range range = c.options.range.value_or(c.report.source_range);
  const auto relative = [&](double v) {
    return static_cast<float>(std::clamp(v - c.options.quantiser.air, -double{FLT_MAX}, double{FLT_MAX}));
  };
  return {relative(range.low), relative(range.high)};
}

namespace {

// A double may be finite, and not a float.
std::string why_not_finite(const Frame& frame, const std::array<int64_t, 3>& voxel) {
  const Region here{voxel, {voxel[0] + 1, voxel[1] + 1, voxel[2] + 1}};
  double value = std::numeric_limits<double>::quiet_NaN();
  for (const FrameBox& box : frame.boxes())
    if (box.type == SourceType::f64 && !frame.region(box).cut(here).empty())
      std::memcpy(&value, frame.sample(box, voxel[0], voxel[1], voxel[2]), sizeof value);
  if (!std::isfinite(value)) return "not finite, the first one";
  return concat("beyond 32-bit floats or not finite, the first one, ", value, ",");
}

} // namespace

Frame Fit::State::frame_of(const Channel& c, std::span<const FrameBox> boxes) const {
  Frame frame{boxes, source_dims(), c.options.air.value_or(c.options.quantiser.air),
              concat("channel '", c.options.name, "', frame ", c.given)};
  frame.set_given(scope.given);
  return frame;
}

FrameScan Fit::State::check_frame(int index, std::span<const FrameBox> boxes) const {
  const Channel& c = channel(index);
  if (c.given == INT32_MAX) fail(Code::limit_exceeded, "too many frames: at most 2147483647");
  const std::string what = concat("channel '", c.options.name, "', frame ", c.given);
  const Frame frame = frame_of(c, boxes);
  FrameScan scan = scan_frame(frame, c.options.threshold, context, &scope.counted);
  if (scan.nonfinite > 0 && options.nonfinite == NonFinite::error) {
    const auto& at = scan.first_nonfinite;
    fail(Code::nonfinite_value, what, ": ", scan.nonfinite, " values are ", why_not_finite(frame, at),
         " at voxel (", at[0], ", ", at[1], ", ", at[2], "); treat them as holes, or clamp them");
  }
  if (options.nonfinite == NonFinite::hole && options.fill.bounded() && !is_block() && scan.finite == 0)
    fail(Code::nonfinite_value, what,
         ": none of its values is finite, and with fixed_predictions a frame is ",
         "not filled from those beside it; leave it out of the series, or write without fixed_predictions");
  if (!is_known(scan) && options.part && c.given > 0 && c.given == options.part->first_given)
    fail(Code::wrong_state, what, ": it is missing altogether; a part begins with a frame that is not");
  if (counts_frame(c.given) && scan.finite > 0) c.check_range(scan.low, scan.high, what);
  return scan;
}

void Fit::State::count_frame(Channel& c, const FrameScan& scan) const {
  if (!counts_frame(c.given)) return;
  if (scan.finite > 0) c.note_range(scan.low, scan.high);
  // Ranges of blocks are joined, so a block without a value has none.
  c.report.frames.push_back(scan.finite > 0 || !is_block() ? Range{scan.low, scan.high} : no_range);
  c.report.source_samples += scope.counted.samples();
  c.report.cc_relevant += scan.relevant;
  c.report.nonfinite += scan.nonfinite;
}

PreparedFrame Fit::State::prepare_frame(int index, std::span<const FrameBox> boxes, const FrameScan& scan) {
  Channel& c = channel(index);
  PreparedFrame made{frame_of(c, boxes), scan, {}, usual_face_levels};
  count_frame(c, scan);
  if ((scan.nonfinite > 0 || is_block()) && options.nonfinite == NonFinite::clamp) {
    const auto [low, high] = clamp_range(c);
    made.frame.clamp(low, high);
  }
  if (options.nonfinite == NonFinite::hole)
    made.holes = patch_holes(made.frame, scan, options.turning, options.fill, context);
  made.frame.set_given(scope.seen);
  if (options.masks && !made.holes.missing.empty()) {
    std::vector<std::byte> runs = mask_runs(made.holes, made.frame.dims(), scope.counted);
    if (!runs.empty()) mask_sink(index, c.given, std::move(runs));
  }
  if (!c.lowpass) made.faces = faces_of(made.frame);
  return made;
}

FaceLevels Fit::State::faces_of(const Frame& frame) const {
  const bool chosen = lattice.has_margins() && !options.fixed_predictions;
  return chosen ? choose_face_levels(frame, lattice) : usual_face_levels;
}

void Fit::State::add_frame(int index, const PreparedFrame& given, const FrameImage& image) {
  Channel& c = channel(index);
  ++c.given;
  const bool known = is_known(given.scan);
  if (!c.lowpass) return take_frame(c, image, known, given.holes);
  c.lowpass->add(known ? &given.frame : nullptr, given.holes.copy(context.memory), filtered(c), context);
  if (c.given == options.dims[3]) finish_lowpass(c);
}

void Fit::State::finish_lowpass(Channel& c) {
  if (c.lowpass && !std::exchange(c.filtered, true)) c.lowpass->finish(filtered(c), context);
}

// Returns what takes a frame from the low-pass.
Lowpass::Sink Fit::State::filtered(Channel& c) {
  return [this, &c](const Frame& frame, const HoleMap& holes) {
    const FrameScan scan = scan_frame(frame, 0, context);
    take_frame(c, {frame, scan.cells, faces_of(frame)}, scan.finite > 0, holes);
  };
}

void Fit::State::take_frame(Channel& c, const FrameImage& image, bool known, const HoleMap& holes) {
  // What would end the series before this frame need not stay beside it.
  if (!lattice.is_static() && !options.periodic) {
    forget_frames(c, int64_t{c.frames} + 1);
    if (known && layers_are_frames()) forget_made(c, 0);
  }
  // A frame that is missing altogether holds what the one before holds, the first ones what follows them;
  // layers that reach the next one take what lies between (weigh_gaps).
  FrameSites sites;
  if (!known && !c.window.empty()) {
    sites.block = c.window.back().block;
    sites.gap = c.any_known ? c.window.back().gap + 1 : 0;
  } else {
    const SpatialResampler& resampler = resampler_of(image);
    sites = resampler.resample(image.frame, image.cells, c.options.unit, pool, context,
                               resampler.whole_tiles(layer_bricks().made));
  }
  if (known && !c.any_known) {
    for (FrameSites& earlier : c.head) earlier.block = sites.block;
    for (FrameSites& earlier : c.window) earlier.block = sites.block;
  }
  c.any_known = c.any_known || known;
  sites.holes = mark_sites(holes, lattice);
  sites.masked = options.masks;
  if (options.masks)
    sites.deep = mark_sites(
        deep_holes(holes, source_dims(), mask_reach_of(options, lattice), options.turning, context), lattice);
  c.window.push_back(std::move(sites));
  ++c.frames;
  make_layers(c);
}

const SpatialResampler& Fit::State::resampler_of(const FrameImage& image) {
  const auto found = resamplers.find(image.faces);
  if (found != resamplers.end()) return found->second;
  const Lattice4 seen = lattice_over(image.frame.dims(), lattice);
  return resamplers.try_emplace(image.faces, seen, image.faces).first->second;
}

DirectLayerScan Fit::State::check_layer(int index, std::span<const float> samples) const {
  const Channel& c = channel(index);
  const int32_t layer = layers_given ? c.next_layer : 0;
  const int coset = lattice.coset(layer);
  if (samples.size() != static_cast<uint64_t>(lattice.space.sites(coset)))
    fail(Code::invalid_argument, "layer ", layer, " has ", lattice.space.sites(coset), " sites, not ",
         samples.size());
  const DirectLayerScan scan = scan_layer(samples, c.options.quantiser.air);
  const std::string what = concat("channel '", c.options.name, "', layer ", layer);
  if (scan.nonfinite > 0 && options.nonfinite == NonFinite::error) {
    const Int3 n = lattice.space.dims(coset);
    const auto nx = static_cast<size_t>(n[0]), ny = static_cast<size_t>(n[1]), first = scan.first_nonfinite;
    fail(Code::nonfinite_value, what, ": ", scan.nonfinite, " values are not finite, the first one at site (",
         first % nx, ", ", first / nx % ny, ", ", first / nx / ny, "); treat them as holes, or clamp them");
  }
  if (scan.finite > 0) c.check_range(scan.low, scan.high, what);
  return scan;
}

void Fit::State::add_layer(int index, std::span<const float> samples, const DirectLayerScan& scan) {
  Channel& c = channel(index);
  if (!std::exchange(layers_given, true)) {
    turn.first_layer = 0;
    for (const auto& each : channels) each->next_layer = each->slab_index = 0;
  }
  const int32_t layer = c.next_layer;
  const BrickLayer shape(lattice.space, lattice.coset(layer));
  if (scan.finite > 0) c.note_range(scan.low, scan.high);
  c.report.source_samples += samples.size();
  c.report.nonfinite += scan.nonfinite;
  const FrameSites sites =
      layer_sites(shape, samples, c.options.quantiser.air, options.nonfinite, clamp_range(c), pool, context);
  const LayerTap tap{&sites, 1};
  ++c.next_layer;
  emit(c, layer, {&tap, 1}, 0);
}

} // namespace bccsplat
