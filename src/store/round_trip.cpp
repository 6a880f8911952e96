// SPDX-License-Identifier: Apache-2.0
// Holds source frames until the stored layers around them are there, makes the time slice that a reader
// would, and has it compared. Layers that no later frame needs are let go. The layers of a frame are made at
// once for boxes, one by one for the whole frame, which takes several times the memory at once. Where the
// field goes through the samples at their sites, a frame is compared with its layer alone.
#include "store/round_trip.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "kernel/cc_kernel.h"
#include "slice/time_slice.h"
#include "store/based_layers.h"
#include "store/measured_boxes.h"
#include "store/site_planes.h"

namespace bccsplat {
namespace {

// Returns the layers around a frame; those of a periodic series in numbers that count on beyond its ends.
LayerSpan span_of(const Lattice4& lattice, int32_t reach, uint32_t frame) {
  if (lattice.is_static()) return {0, lattice.layers()};
  const int32_t layer = lattice.lead + static_cast<int32_t>(std::floor(frame / lattice.time_step));
  if (lattice.periodic) return {layer - reach - 1, layer + reach + 2};
  return {std::max(0, layer - reach - 1), std::min(layer + reach + 2, lattice.layers())};
}

} // namespace

LayerSpan layers_to_measure(const Lattice4& lattice, const std::string& kernel, uint32_t frame) {
  return span_of(lattice, layers_in_reach(lattice, kernel), frame);
}

// What is measured of a channel with one base of its field.
class MeasuredField {
 public:
  // bricks: those of its coefficients that are made.
  MeasuredField(const SampleSource& layers, std::string kernel, float prune, uint64_t cache_bytes,
                const BrickBox& bricks)
      : layers_(layers), kernel_(std::move(kernel)), prune_(prune), cache_bytes_(cache_bytes),
        bricks_(bricks) {
    renew();
  }
  // Makes its coefficients anew, of layers that end elsewhere.
  void renew() { field_.emplace(layers_, 0, make_kernel(kernel_), prune_, cache_bytes_, bricks_); }
  [[nodiscard]] const Coefficients& field() const { return *field_; }
  // Returns the coefficients of some bricks alone.
  [[nodiscard]] Coefficients part(const BrickBox& bricks) const {
    return {layers_, 0, make_kernel(kernel_), prune_, cache_bytes_, bricks};
  }

  SampleErrors total;
  std::vector<SampleErrors> each; // by frame to be measured

 private:
  const SampleSource& layers_;
  std::string kernel_;
  float prune_;
  uint64_t cache_bytes_;
  BrickBox bricks_;
  std::optional<Coefficients> field_;
};

// A box of a frame and its samples.
struct HeldBox {
  MeasuredBox box;
  HeldFrame samples;
};

struct RoundTrip::Channel {
  Channel(const Lattice4& lattice, const RoundTripChannel& o, const std::string& kernel, uint64_t cache_bytes,
          const RoundTripScope& scope)
      : options(o), window(lattice, static_cast<float>(o.air), scope.first_layer, o.sample_step),
        kernel_name(kernel), bricks(scope.bricks), based(window),
        cache(std::min(coefficient_cache_bytes(lattice, kernel), cache_bytes)),
        // The prune threshold of an open volume.
        above_air(window, kernel, o.threshold / 2, cache, bricks) {}

  RoundTripChannel options;
  LayerWindow window;
  std::string kernel_name;
  BrickBox bricks;
  BasedLayers based;
  uint64_t cache;
  MeasuredField above_air;
  // Beside it where readers will take a base other than air, as far as is known; in its place where
  // corrections keep a bound, as these tell the base.
  std::unique_ptr<MeasuredField> above_base;
  bool base_chosen = false;                        // or air
  std::map<uint32_t, std::vector<HeldBox>> frames; // to be measured
  std::optional<EarlierFrames> earlier;            // before the next of them, where it is compared in boxes
  size_t next = 0;                                 // of the frames to be measured
  std::span<const SampleLayer> given;              // those that are measured just now, as they were given
  int32_t given_first = 0;
  float largest = 0; // distance from the base of the layers so far, where these are compared
  // The layers of a periodic series come from one of them on until they are complete, which tells the frame
  // that is measured first. Those before it wait for the last layers, or all do.
  bool begun = false, all_wait = false;
  int32_t complete = 0;
  size_t start = 0;

  void push(const SampleLayer& layer) {
    window.push(layer);
    if (!base_chosen || (above_base && !corrects())) based.see(layer);
  }
  // When the layers of the first frame to be measured are there; of a part nobody knows what readers of the
  // series will take.
  void choose_base() {
    if (base_chosen) return;
    base_chosen = true;
    if (!options.whole || !based.far_from_air()) return;
    based.settle();
    above_base = std::make_unique<MeasuredField>(based, kernel_name, 0.0f, cache, bricks);
  }
  [[nodiscard]] bool corrects() const { return options.bound > 0; }
  [[nodiscard]] float base() const { return above_base ? based.base(0) : window.air(0); }
  [[nodiscard]] const MeasuredField& measured(bool at_sites) const {
    return above_base && !at_sites && (corrects() || based.far_from_air()) ? *above_base : above_air;
  }
  void forget(int32_t first, int32_t end) const {
    above_air.field().forget(first, end);
    if (above_base) above_base->field().forget(first, end);
  }
  void set_lattice(const Lattice4& lattice) {
    window.set_lattice(lattice);
    above_air.renew();
    if (above_base) above_base->renew();
  }
};

namespace {

// Layers first .. end - 1 that a field at an instant is a sum of; of a periodic series in numbers that count
// on beyond its ends.
LayerSpan layers_of(const Coefficients& field, uint32_t frame) {
  const Lattice4& lattice = field.source().lattice();
  LayerSpan span{INT32_MAX, INT32_MIN};
  for (const LayerWeight& l : instant_weights(lattice, field.kernel(), frame)) {
    const int32_t at = lattice.periodic ? l.layer : lattice.mirror_layer(l.layer);
    span = {std::min(span.begin, at), std::max(span.end, at + 1)};
  }
  return span;
}

// Makes the layers of an instant one after the other, so that no more of what they are made of is held than
// one of them needs.
void make_layers(const Coefficients& field, const LayerSpan& span, const Context& context) {
  for (int32_t m = span.begin; m < span.end; ++m) {
    [[maybe_unused]] const auto made = field.compact_layers(std::span(&m, 1), context);
    if (m < field.source().lattice().layers()) field.forget(span.begin, m + 1);
  }
}

ComparedPart::Plane plane_of(const HeldFrame& held) {
  return [&held](int64_t z, double* to) { held.plane(z, to); };
}

ComparedPart part_of(const HeldFrame& held, uint32_t frame, const Lattice4& lattice, double doubt) {
  return {plane_of(held), held.grid(), frame, lattice.dims, doubt};
}

// Are the sites of a layer the samples of a frame, all of which are stored, and the field what they are?
bool layers_are_frames(const Lattice4& lattice, const std::vector<RoundTripChannel>& channels,
                       const std::string& kernel) {
  const bool all_kept =
      std::all_of(channels.begin(), channels.end(), [](const auto& c) { return c.threshold == 0; });
  const Int3 sites = lattice.space.dims(0);
  for (size_t a = 0; a < 3; ++a) // an axis of one sample has two sites
    if (static_cast<uint32_t>(sites[a]) != lattice.dims[a]) return false;
  return all_kept && !lattice.periodic && lattice.lead == 0 && lattice.sites_are_samples() &&
         goes_through_samples(lattice, make_kernel(kernel));
}

} // namespace

RoundTrip::RoundTrip(const Lattice4& lattice, const std::vector<RoundTripChannel>& channels,
                     std::string kernel, std::vector<uint32_t> frames, ResidualSink sink,
                     const Context& context, const RoundTripScope& scope)
    : lattice_(lattice), kernel_(std::move(kernel)), frames_(std::move(frames)), sink_(std::move(sink)),
      context_(context), scope_(scope) {
  scope_.at_sites = scope.at_sites && layers_are_frames(lattice, channels, kernel_);
  for (const RoundTripChannel& c : channels)
    channels_.push_back(
        std::make_unique<Channel>(lattice_, c, kernel_, context.memory.limit() / 4 / channels.size(), scope));
}

RoundTrip::~RoundTrip() = default;

void RoundTrip::set_lattice(const Lattice4& lattice) {
  lattice_ = lattice;
  std::erase_if(frames_, [&](uint32_t frame) { return frame >= lattice.dims[3]; });
  for (const auto& c : channels_) c->set_lattice(lattice);
}

void RoundTrip::add_frame(int channel, uint32_t frame, std::span<const FrameBox> boxes) {
  const auto measured = [&](uint32_t f) { return std::binary_search(frames_.begin(), frames_.end(), f); };
  Channel& c = *channels_[channel];
  const double air = c.options.air;
  const bool as_given = scope_.at_sites && c.options.as_given != SourceType::unknown &&
                        std::all_of(boxes.begin(), boxes.end(),
                                    [&](const FrameBox& b) { return b.type == c.options.as_given; });
  if (measured(frame) && !as_given) {
    const std::vector<MeasuredBox> chosen =
        scope_.in_boxes
            ? choose_measured_boxes(lattice_, frame, boxes, air, c.earlier ? &*c.earlier : nullptr)
            : std::vector{scope_.samples.empty() ? whole_frame(lattice_) : MeasuredBox{scope_.samples}};
    std::vector<HeldBox>& held = c.frames[frame];
    for (const MeasuredBox& box : chosen) {
      const HeldGrid grid = held_grid(box.samples, scope_.every);
      held.push_back({box, HeldFrame(boxes, air, context_.memory, grid)});
    }
  }
  // A level errs in space far more than in time.
  if (!scope_.in_boxes || scope_.every > 1) return;
  if (measured(frame + 1) || measured(frame + 2)) {
    const std::array<int64_t, 3> dims{lattice_.dims[0], lattice_.dims[1], lattice_.dims[2]};
    if (!c.earlier) c.earlier.emplace(dims, air, context_.memory);
    c.earlier->see(frame, boxes);
  } else {
    c.earlier.reset();
  }
}

// What the frames need that wait for the last layers of a periodic series is kept until then.
void RoundTrip::begin_turn(Channel& c, int32_t first) const {
  const int32_t reach = layers_in_reach(lattice_, kernel_), layers = lattice_.layers();
  c.complete = first + layers;
  int32_t kept = first;
  for (; c.start < frames_.size(); ++c.start) {
    const LayerSpan needed = span_of(lattice_, reach, frames_[c.start]);
    if (needed.begin >= first) break;
    kept = std::max(kept, needed.end);
  }
  c.all_wait = c.start == frames_.size();
  if (c.all_wait) c.start = 0, kept = c.complete;
  if (!frames_.empty()) kept = std::max(kept, span_of(lattice_, reach, frames_.back()).end - layers);
  c.window.turn_from(first, std::min(kept, c.complete));
}

// The layers that must be there to measure a frame.
LayerSpan RoundTrip::needed_for(const Channel& c, size_t at) const {
  const int32_t layers = lattice_.layers();
  if (scope_.at_sites) {
    const auto layer = static_cast<int32_t>(frames_[at]);
    return {layer, layer + 1};
  }
  LayerSpan needed = span_of(lattice_, layers_in_reach(lattice_, kernel_), frames_[at]);
  if (!lattice_.periodic) return needed;
  if (c.all_wait) return {c.complete - layers, c.complete};
  if (at < c.start) needed.begin += layers, needed.end += layers; // in the second turn
  return {needed.begin, std::min(needed.end, c.complete)};
}

void RoundTrip::add_layers(int channel, int32_t first_layer, const SlabLayers& layers,
                           std::span<const SampleLayer> given) {
  Channel& c = *channels_[channel];
  c.given = given, c.given_first = first_layer;
  if (!c.begun && lattice_.periodic) begin_turn(c, first_layer);
  c.begun = true;
  for (const SampleLayer& layer : layers.compact()) {
    c.push(layer);
    choose_base_when_due(c); // however many layers come at once
  }
  if (scope_.at_sites) note_layers(c, layers.compact());
  measure_ready(channel);
}

void RoundTrip::choose_base_when_due(Channel& c) const {
  if (c.base_chosen || scope_.at_sites || frames_.empty()) return;
  if (c.window.end() >= needed_for(c, c.start).end) c.choose_base();
}

void RoundTrip::measure_ready(int channel) {
  Channel& c = *channels_[channel];
  choose_base_when_due(c);
  while (c.next < frames_.size()) {
    const size_t at = (c.start + c.next) % frames_.size();
    const LayerSpan needed = needed_for(c, at);
    c.window.forget(needed.begin);
    if (c.window.end() < needed.end) return;
    // Layers beyond the end mirror those before it.
    measure(c, channel, at);
    if (++c.next == frames_.size()) break;
    if (scope_.at_sites) continue;
    const Coefficients& field = c.above_air.field();
    const uint32_t next = frames_[(c.start + c.next) % frames_.size()];
    const int32_t made = layers_of(field, frames_[at]).end, first = layers_of(field, next).begin;
    c.forget(first, std::max(first, made));
  }
  c.window.forget_all();
  c.forget(lattice_.layers(), INT32_MAX);
}

void RoundTrip::measure(Channel& c, int index, size_t at) {
  const uint32_t frame = frames_[at];
  FrameResiduals residuals;
  const auto add = [&](MeasuredField& to) {
    to.each.resize(frames_.size());
    to.each[at] = compare(c, to, frame, residuals);
    to.total.add(to.each[at]);
  };
  if (scope_.at_sites) {
    add(c.above_air);
  } else {
    if (c.above_base) add(*c.above_base);
    if (!c.above_base || !c.corrects()) add(c.above_air);
  }
  c.frames.erase(frame);
  if (!residuals.empty() && sink_) sink_(index, frame, residuals);
}

void RoundTrip::note_layers(Channel& c, std::span<const SampleLayer> layers) const {
  c.choose_base(); // of the first ones
  if (!c.corrects()) return;
  const float air = static_cast<float>(c.options.air) - c.base();
  for (const SampleLayer& layer : layers)
    c.largest = std::max(c.largest, largest_at_sites(layer, air, context_));
}

SampleErrors RoundTrip::compare_at_sites(const Channel& c, uint32_t frame, FrameResiduals& residuals) const {
  const SampleLayer& layer = c.window.layer(static_cast<int32_t>(frame));
  const float air = c.window.air(0);
  const auto read = [&](int64_t z, int64_t count, float* to) {
    const int64_t samples = int64_t{layer.dims()[0]} * layer.dims()[1];
    context_.tasks.parallel_for(static_cast<uint64_t>(count), [&](uint64_t i) {
      context_.progress.check();
      read_site_plane(layer, air, z + static_cast<int64_t>(i), to + static_cast<int64_t>(i) * samples);
    });
  };
  ComparedPart part{{},
                    held_grid(whole_frame(lattice_).samples, 1),
                    frame,
                    lattice_.dims,
                    exact_rounding * c.largest + c.options.read_off};
  const auto held = c.frames.find(frame);
  if (held != c.frames.end()) {
    part.plane = plane_of(held->second.front().samples);
  } else {
    const SampleLayer& given = c.given[static_cast<int32_t>(frame) - c.given_first];
    part.plane = [&given, air, &part](int64_t z, double* to) {
      std::vector<float> values(static_cast<size_t>(part.grid.dims[0] * part.grid.dims[1]));
      read_site_plane(given, air, z, values.data());
      std::copy(values.begin(), values.end(), to);
    };
  }
  return compare_samples(read, c.options, part, residuals, context_);
}

SampleErrors RoundTrip::compare(const Channel& c, const MeasuredField& field, uint32_t frame,
                                FrameResiduals& residuals) const {
  if (scope_.at_sites) return compare_at_sites(c, frame, residuals);
  const std::vector<HeldBox>& boxes = c.frames.at(frame);
  const Kernel& kernel = field.field().kernel();
  // Where the field goes through its samples it is as far off there as these are, whatever filters make of
  // others.
  const double gain = goes_through_samples(lattice_, kernel) ? 1 : kernel.prefilter_gain,
               doubt = c.options.read_off * gain * largest_site_sum(lattice_.space.bcc);
  if (boxes.size() == 1 && boxes.front().box.is_whole()) {
    const Coefficients& all = field.field();
    make_layers(all, layers_of(all, frame), context_);
    const Slice slice = time_slice(all, frame, {0, 0}, {}, context_);
    return compare_samples(slice, c.options, part_of(boxes.front().samples, frame, lattice_, doubt),
                           residuals, context_);
  }
  BoxErrors sum;
  for (const HeldBox& held : boxes) {
    const Coefficients part = field.part(held.box.bricks);
    const Slice slice = time_slice(part, frame, {0, 0}, {}, context_);
    sum.add(
        compare_samples(slice, c.options, part_of(held.samples, frame, lattice_, doubt), residuals, context_),
        held.box.weight);
  }
  return sum.of_frame();
}

std::optional<float> RoundTrip::base(int channel) const {
  const Channel& c = *channels_[channel];
  return c.above_base && c.corrects() ? std::optional(c.based.base(0)) : std::nullopt;
}

const SampleErrors& RoundTrip::errors(int channel) const {
  return channels_[channel]->measured(scope_.at_sites).total;
}
const SampleErrors& RoundTrip::frame_errors(int channel, size_t i) const {
  return channels_[channel]->measured(scope_.at_sites).each.at(i);
}

} // namespace bccsplat
