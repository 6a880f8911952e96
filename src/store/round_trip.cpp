// SPDX-License-Identifier: Apache-2.0
// Holds source frames until the stored layers around them are there, makes the time slice that a reader
// would, and compares plane by plane; where a bound is missed it counts the steps of a correction. Layers
// that no later frame needs are let go.
#include "store/round_trip.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "base/error.h"
#include "field/sample_grid.h"
#include "slice/time_slice.h"
#include "store/based_layers.h"

namespace bccsplat {
namespace {

constexpr int64_t samples_at_a_time = 1 << 22;
// Other ways to the same sample (evaluate at a point) round differently by a few units in the last place.
constexpr double rounding = 0x1p-21;

// What one plane of a frame adds.
struct PlaneErrors {
  SampleErrors errors;
  FrameResiduals residuals;
};

struct PlaneJob {
  const RoundTripChannel& channel;
  const HeldFrame& source;
  std::array<int64_t, 3> n; // samples that are compared
  int64_t every;            // of the source's
  uint32_t frame;

  void compare(int64_t z, const float* got, PlaneErrors& out) const;

 private:
  [[noreturn]] void refuse(int64_t z, int64_t i, double expected, double reached) const {
    fail(Code::bound_not_met, "channel '", channel.name, "', frame ", frame, ", voxel (", i % n[0], ", ",
         i / n[0], ", ", z, "): the source has ", expected, ", the file would give ", reached,
         ", more than the bound of ", channel.bound,
         " away even with a correction: values near that magnitude are read as 32-bit floats, which hold ",
         "errors down to about ", std::fabs(expected) * rounding * 2, "; accept that much");
  }
};

void PlaneJob::compare(int64_t z, const float* got, PlaneErrors& out) const {
  std::vector<double> expected(static_cast<size_t>(n[0] * n[1]));
  source.plane(z, n[0], n[1], expected.data());
  const double bound = channel.bound, step = RoundTrip::step(bound);
  const auto air = static_cast<double>(channel.air);
  SampleErrors& e = out.errors;
  for (int64_t i = 0; i < n[0] * n[1]; ++i) {
    const double want = expected[static_cast<size_t>(i)];
    if (!std::isfinite(want)) continue;
    const auto voxel = static_cast<uint64_t>(z * n[0] * n[1] + i);
    float value = got[i];
    const bool lost = std::isnan(value);
    if (lost && bound == 0) {
      ++e.lost;
      continue;
    }
    if (!lost) e.bare.add(static_cast<double>(value) - want);
    const double from = lost ? air : static_cast<double>(value), off = want - from;
    const double margin = rounding * std::max({std::fabs(want), std::fabs(from), std::fabs(air)});
    if (bound > 0 && (lost || (off != 0 && !(std::fabs(off) <= bound - margin)))) {
      const double steps = std::nearbyint(off / step);
      if (!(std::fabs(steps) < 0x1p53)) refuse(z, i, want, from);
      // As the reader computes it.
      value = static_cast<float>(from) + static_cast<float>(steps * step);
      if (!(std::fabs(static_cast<double>(value) - want) <= bound))
        refuse(z, i, want, static_cast<double>(value));
      (lost ? out.residuals.set : out.residuals.add).push_back({voxel, static_cast<int64_t>(steps)});
      ++e.corrected;
    }
    const double difference = static_cast<double>(value) - want;
    if (e.all.count == 0 || std::fabs(difference) > e.all.largest) {
      e.frame = frame;
      e.voxel = {static_cast<uint64_t>(i % n[0] * every), static_cast<uint64_t>(i / n[0] * every),
                 static_cast<uint64_t>(z * every)};
      e.expected = want, e.got = static_cast<double>(value);
    }
    e.all.add(difference);
    if (std::fabs(want - air) > static_cast<double>(channel.threshold)) e.non_air.add(difference);
  }
}

} // namespace

void ErrorSum::add(double difference) {
  largest = std::max(largest, std::fabs(difference));
  squares += difference * difference;
  ++count;
}

void ErrorSum::add(const ErrorSum& other) {
  largest = std::max(largest, other.largest);
  squares += other.squares;
  count += other.count;
}

double ErrorSum::rms() const { return count ? std::sqrt(squares / static_cast<double>(count)) : 0; }

double ErrorSum::psnr(double peak) const {
  if (count == 0) return std::numeric_limits<double>::quiet_NaN();
  return squares == 0 ? std::numeric_limits<double>::infinity() : 20 * std::log10(peak / rms());
}

void SampleErrors::add(const SampleErrors& other) {
  if (other.all.count > 0 && (all.count == 0 || other.all.largest > all.largest))
    frame = other.frame, voxel = other.voxel, expected = other.expected, got = other.got;
  all.add(other.all), non_air.add(other.non_air), bare.add(other.bare);
  lost += other.lost, corrected += other.corrected;
}

void require_psnr(const std::string& channel, const SampleErrors& e, const Range& range, double psnr) {
  const double peak = range.high - range.low, reached = e.all.psnr(peak);
  if (peak == 0 && e.all.squares > 0)
    fail(Code::bound_not_met, "channel '", channel, "': the source is ", range.low,
         " everywhere, so that no PSNR can be told; make that its air, or bound the error itself");
  if (!(reached < psnr)) return;
  // Corrections within a bound leave two thirds of it in the mean.
  const double bound = 1.5 * peak * std::pow(10, -psnr / 20),
               magnitude = std::max(std::fabs(range.low), std::fabs(range.high)),
               held = 2 * rounding * magnitude;
  const std::string advice =
      bound >= held
          ? concat("a smaller scale, lattice CC, more bits, or abs_error ", bound, " would do")
          : concat("values near ", magnitude, " are read as 32-bit floats, which hold errors down to about ",
                   held, "; ask for at most ", 20 * std::log10(1.5 * peak / held), " dB");
  fail(Code::bound_not_met, "channel '", channel, "': ", reached, " dB reached, ", psnr,
       " asked for; the largest difference is at frame ", e.frame, ", voxel (", e.voxel[0], ", ", e.voxel[1],
       ", ", e.voxel[2], "): ", e.got, " instead of ", e.expected, "; ", advice);
}

namespace {

// Of a periodic series in numbers that count on beyond its ends.
LayerSpan span_of(const Lattice4& lattice, int32_t reach, uint32_t frame) {
  if (lattice.is_static()) return {0, lattice.layers()};
  const int32_t layer = lattice.lead + static_cast<int32_t>(std::floor(frame / lattice.time_step));
  if (lattice.periodic) return {layer - reach - 1, layer + reach + 2};
  return {std::max(0, layer - reach - 1), std::min(layer + reach + 2, lattice.layers())};
}

} // namespace

LayerSpan layers_to_measure(const Lattice4& lattice, const std::string& kernel, bool coefficients,
                            uint32_t frame) {
  const LayerWindow stored(lattice, 0, coefficients ? make_kernel(kernel).name : std::string());
  return span_of(lattice, layers_in_reach(stored, kernel), frame);
}

// What is measured of a channel with one base of its field.
class MeasuredField {
 public:
  MeasuredField(const SampleSource& layers, std::string kernel, float prune, uint64_t cache_bytes)
      : layers_(layers), kernel_(std::move(kernel)), prune_(prune), cache_bytes_(cache_bytes) {
    renew();
  }
  // Makes its coefficients anew, of layers that end elsewhere.
  void renew() { field_.emplace(layers_, 0, make_kernel(kernel_), prune_, cache_bytes_); }
  [[nodiscard]] const Coefficients& field() const { return *field_; }

  SampleErrors total;
  std::vector<SampleErrors> each; // by frame to be measured

 private:
  const SampleSource& layers_;
  std::string kernel_;
  float prune_;
  uint64_t cache_bytes_;
  std::optional<Coefficients> field_;
};

struct RoundTrip::Channel {
  Channel(const Lattice4& lattice, const RoundTripChannel& o, const std::string& kernel, bool coefficients,
          uint64_t cache_bytes, int32_t first_layer)
      : options(o), window(lattice, o.air, coefficients ? make_kernel(kernel).name : std::string(),
                           first_layer, o.sample_step),
        kernel_name(kernel), based(window),
        cache(std::min(coefficient_cache_bytes(window, kernel), cache_bytes)),
        // The prune threshold of an open volume.
        above_air(window, kernel, o.threshold / 2, cache) {}

  RoundTripChannel options;
  LayerWindow window;
  std::string kernel_name;
  BasedLayers based;
  uint64_t cache;
  MeasuredField above_air;
  // Beside it where readers will take a base other than air, as far as is known; in its place where
  // corrections keep a bound, as these tell the base.
  std::unique_ptr<MeasuredField> above_base;
  bool base_chosen = false;             // or air
  std::map<uint32_t, HeldFrame> frames; // to be measured
  size_t next = 0;                      // of the frames to be measured
  // Of a periodic series, whose layers come from one of them on until they are complete: the frame that is
  // measured first. Those before it wait for the last layers, or all do.
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
    above_base = std::make_unique<MeasuredField>(based, kernel_name, 0.0f, cache);
  }
  [[nodiscard]] bool corrects() const { return options.bound > 0; }
  [[nodiscard]] const MeasuredField& measured() const {
    return above_base && (corrects() || based.far_from_air()) ? *above_base : above_air;
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

} // namespace

RoundTrip::RoundTrip(const Lattice4& lattice, const std::vector<RoundTripChannel>& channels,
                     std::string kernel, bool coefficients, std::vector<uint32_t> frames, ResidualSink sink,
                     const Context& context, int32_t first_layer, int32_t every)
    : lattice_(lattice), kernel_(std::move(kernel)), frames_(std::move(frames)), sink_(std::move(sink)),
      context_(context), every_(every) {
  for (const RoundTripChannel& c : channels)
    channels_.push_back(std::make_unique<Channel>(lattice_, c, kernel_, coefficients,
                                                  context.memory.limit() / 4 / channels.size(), first_layer));
}

RoundTrip::~RoundTrip() = default;

void RoundTrip::set_lattice(const Lattice4& lattice) {
  lattice_ = lattice;
  std::erase_if(frames_, [&](uint32_t frame) { return frame >= lattice.dims[3]; });
  for (const auto& c : channels_) c->set_lattice(lattice);
}

void RoundTrip::add_frame(int channel, uint32_t frame, std::span<const FrameBox> boxes) {
  if (!std::binary_search(frames_.begin(), frames_.end(), frame)) return;
  Channel& c = *channels_[static_cast<size_t>(channel)];
  c.frames.emplace(frame, HeldFrame(boxes, static_cast<double>(c.options.air), context_.memory, every_));
}

// What the frames need that wait for the last layers of a periodic series is kept until then.
void RoundTrip::begin_turn(Channel& c, int32_t first) const {
  const int32_t reach = layers_in_reach(c.window, kernel_), layers = lattice_.layers();
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
  LayerSpan needed = span_of(lattice_, layers_in_reach(c.window, kernel_), frames_[at]);
  if (!lattice_.periodic) return needed;
  if (c.all_wait) return {c.complete - layers, c.complete};
  if (at < c.start) needed.begin += layers, needed.end += layers; // in the second turn
  return {needed.begin, std::min(needed.end, c.complete)};
}

void RoundTrip::add_layers(int channel, int32_t first_layer, const SlabLayers& layers) {
  Channel& c = *channels_[static_cast<size_t>(channel)];
  if (!c.begun && lattice_.periodic) begin_turn(c, first_layer);
  c.begun = true;
  for (const SampleLayer& layer : layers.compact()) {
    c.push(layer);
    // However many layers come at once.
    if (!c.base_chosen && !frames_.empty() && c.window.end() >= needed_for(c, c.start).end) c.choose_base();
  }
  while (c.next < frames_.size()) {
    const size_t at = (c.start + c.next) % frames_.size();
    const LayerSpan needed = needed_for(c, at);
    c.window.forget(needed.begin);
    if (c.window.end() < needed.end) return;
    // Layers beyond the end mirror those before it.
    measure(c, channel, at);
    if (++c.next == frames_.size()) break;
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
    to.each[at] = compare(c, to.field(), frame, residuals);
    to.total.add(to.each[at]);
  };
  if (c.above_base) add(*c.above_base);
  if (!c.above_base || !c.corrects()) add(c.above_air);
  c.frames.erase(frame);
  if (!residuals.empty() && sink_) sink_(index, frame, residuals);
}

namespace {

// Appends the lists of planes, the first of so many that are left of a frame; room is made for all of them as
// if the others had as many corrections, so that what is there moves once or not at all.
void append(std::span<const PlaneErrors> planes, ResidualList FrameResiduals::*list, int64_t left,
            FrameResiduals& to, Progress& progress) {
  size_t count = 0;
  for (const PlaneErrors& p : planes) count += (p.residuals.*list).size();
  ResidualList& all = to.*list;
  if (all.size() + count > all.capacity())
    all.reserve(all.size() + count * static_cast<size_t>(left) / planes.size() + count);
  for (const PlaneErrors& p : planes) {
    progress.check();
    const ResidualList& plane = p.residuals.*list;
    all.insert(all.end(), plane.begin(), plane.end());
  }
}

} // namespace

SampleErrors RoundTrip::compare(const Channel& c, const Coefficients& field, uint32_t frame,
                                FrameResiduals& residuals) const {
  make_layers(field, layers_of(field, frame), context_);
  const Slice slice = time_slice(field, frame, {0, 0}, {}, context_);
  std::array<int64_t, 3> n;
  for (size_t a = 0; a < 3; ++a) n[a] = (lattice_.dims[a] + every_ - 1) / every_;
  const PlaneJob job{c.options, c.frames.at(frame), n, every_, frame};
  const int64_t planes = std::clamp<int64_t>(samples_at_a_time / (n[0] * n[1]), 1, n[2]);
  const Reservation memory(context_.memory, static_cast<uint64_t>(planes * n[0] * n[1]) * sizeof(float),
                           "samples of a frame to measure the error");
  std::vector<float> values(static_cast<size_t>(planes * n[0] * n[1]));
  SampleErrors errors;
  for (int64_t z = 0; z < n[2]; z += planes) {
    const int64_t count = std::min(planes, n[2] - z);
    Grid grid;
    grid.origin[2] = static_cast<double>(z * every_);
    grid.step.fill(static_cast<double>(every_));
    grid.dims = {static_cast<int32_t>(n[0]), static_cast<int32_t>(n[1]), static_cast<int32_t>(count)};
    sample_grid(slice, grid, values.data(), context_);
    std::vector<PlaneErrors> parts(static_cast<size_t>(count));
    context_.tasks.parallel_for(parts.size(), [&](uint64_t p) {
      context_.progress.check();
      job.compare(z + static_cast<int64_t>(p), values.data() + static_cast<int64_t>(p) * n[0] * n[1],
                  parts[p]);
    });
    for (const PlaneErrors& p : parts) errors.add(p.errors); // in order: the same sums for any thread count
    append(parts, &FrameResiduals::add, n[2] - z, residuals, context_.progress);
    append(parts, &FrameResiduals::set, n[2] - z, residuals, context_.progress);
  }
  return errors;
}

std::optional<float> RoundTrip::base(int channel) const {
  const Channel& c = *channels_[static_cast<size_t>(channel)];
  return c.above_base && c.corrects() ? std::optional(c.based.base(0)) : std::nullopt;
}

const SampleErrors& RoundTrip::errors(int channel) const {
  return channels_[static_cast<size_t>(channel)]->measured().total;
}
const SampleErrors& RoundTrip::frame_errors(int channel, size_t i) const {
  return channels_[static_cast<size_t>(channel)]->measured().each.at(i);
}

} // namespace bccsplat
