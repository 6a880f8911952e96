#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "api/handles.h"
#include "api/structs.h"
#include "fit/coefficient_layers.h"
#include "fit/filter.h"
#include "fit/fit.h"
#include "fit/lowpass.h"
#include "fit/round_trip.h"
#include "formats/bcc4_deflate.h"
#include "formats/bcc4_journal.h"

using namespace bccsplat;
using namespace bccsplat::api;

namespace {

enum class Feeding { nothing, frames, layers };

constexpr uint32_t frames_of_some = 3;     // BCCSPLAT_MEASURE_SOME
constexpr uint64_t field_points = 1 << 16; // asked of a host's field at a time

std::string text_or(const char* text, const char* otherwise) { return text ? text : otherwise; }

// A number of the C ABI as an enum of the core; 0 is the default.
template<class Enum> Enum choose(int32_t value, Enum otherwise, int32_t last, const char* name) {
  if (value < 0 || value > last) fail(Code::invalid_argument, name, " ", value, " is not one of 0 .. ", last);
  return value == 0 ? otherwise : static_cast<Enum>(value);
}

Affine3 read_affine(const double (&m)[16]) {
  Affine3 a;
  if (std::all_of(std::begin(m), std::end(m), [](double v) { return v == 0; })) return a;
  for (const double v : m)
    if (!std::isfinite(v)) fail(Code::invalid_argument, "affine: every element must be finite");
  if (m[12] != 0 || m[13] != 0 || m[14] != 0 || m[15] != 1)
    fail(Code::invalid_argument, "affine: the last row must be 0 0 0 1");
  for (size_t r = 0; r < 3; ++r) {
    for (size_t c = 0; c < 3; ++c) a.linear[r][c] = m[4 * r + c];
    a.offset[r] = m[4 * r + 3];
  }
  if (!(std::fabs(a.determinant()) > 0)) fail(Code::invalid_argument, "affine: the axes do not span space");
  return a;
}

// Codes a caller-chosen step apart, one of them air itself.
Quantiser quantiser_of_step(ValueType type, const Range& range, double step, float air,
                            const std::string& name) {
  const auto zero = static_cast<double>(air);
  const double low = std::min(range.low, zero), high = std::max(range.high, zero);
  const double below = std::ceil((zero - low) / step), above = std::ceil((high - zero) / step);
  if (largest_code(type) == 0 || !(step > 0 && std::isfinite(step)) || !(below + above <= largest_code(type)))
    fail(Code::invalid_argument, "channel ", name, ": value_step ", step, " needs ", below + above + 1,
         " codes from ", low, " to ", high, "; the type has ", largest_code(type) + 1);
  return {type, step, zero - below * step, air};
}

// Coefficients: eight bits and halves fit a half, others need a float.
ValueType coefficient_type(SourceType source) {
  return source == SourceType::u8 || source == SourceType::i8 || source == SourceType::f16 ? ValueType::f16
                                                                                           : ValueType::f32;
}

std::vector<uint32_t> measured_frames(uint32_t frames, bool all) {
  std::vector<uint32_t> list;
  const uint32_t count = all ? frames : std::min(frames, frames_of_some);
  for (uint32_t i = 0; i < count; ++i)
    list.push_back(all ? i : static_cast<uint32_t>(uint64_t{frames} * (2 * i + 1) / (2 * count)));
  return list;
}

} // namespace

// Fit and container are made when the first data come: the source's precision may only be known then.
struct bccsplat_writer : Counted {
  bccsplat_writer(bccsplat_device* owner, const bccsplat_writer_options& options);
  void begin(Feeding kind, uint32_t channel, SourceType first_type);
  void add_frame(uint32_t channel, double time, const bccsplat_box* boxes, uint64_t count);
  void add_layer(uint32_t channel, int64_t layer, std::span<const float> samples);
  void add_field(uint32_t channel, bccsplat_field_fn field, void* user);
  bccsplat_writer_report finish();
  void check_channel(uint32_t channel) const;
  // Runs a step; after a failure the writer is of no use any more.
  template<class Step> void step(const Step& body) {
    if (finished) fail(Code::wrong_state, "writer: finished already");
    if (broken) fail(Code::wrong_state, "writer: an earlier call failed; release it");
    broken = true;
    body();
    broken = false;
  }

  Ref<bccsplat_device> device;
  Progress progress;
  std::unique_ptr<ByteSink> sink;
  VolumeInfo initial;
  FitOptions fit_options;
  std::vector<bccsplat_channel_options> channels; // strings not to be used: copied to `initial`
  Feeding feeding = Feeding::nothing;
  bool finished = false, broken = false;
  std::vector<double> times;
  std::vector<uint64_t> added; // frames or layers, per channel
  uint64_t bytes_source = 0;
  std::unique_ptr<Bcc4Writer> container;
  std::unique_ptr<Fit> fit;
  std::optional<Context> context;
  double abs_error = 0, psnr = 0;
  int32_t measure = 0, partial = 0;
  std::string path;                            // of the file; empty: a stream
  bool coefficients = false, given_up = false; // given_up: measuring
  std::unique_ptr<RoundTrip> round_trip;       // null: nothing is measured
  std::vector<Range> source_ranges;            // once finished

 private:
  // One channel between fit and container, when coefficients are stored.
  struct Prefiltered {
    Prefiltered(const Lattice4& lattice, const Quantiser& quantiser, float threshold,
                const std::string& kernel)
        : maker(lattice, quantiser, threshold, kernel) {}
    CoefficientLayers maker;
    std::vector<BrickLayer> slab;
    int32_t next_slab = 0;
  };
  std::vector<std::unique_ptr<Prefiltered>> prefiltered;

  void make_container();
  [[nodiscard]] uint32_t fingerprint() const;
  [[nodiscard]] Bcc4WriterOptions appended() const;
  [[nodiscard]] bool measuring_required() const {
    return abs_error > 0 || psnr > 0 || measure == BCCSPLAT_MEASURE_ALL;
  }
  void start_measuring(bool frames_known);
  // Runs a step of it. Measuring that is only nice to have ends where memory is short or the lattice has no
  // such kernel.
  template<class Body> void measuring(const Body& body) {
    try {
      body();
    } catch (const Error& e) {
      if (measuring_required() || (e.code() != Code::memory_budget && e.code() != Code::unsupported)) throw;
      round_trip.reset();
      given_up = true;
    }
  }
  void take_layers(int32_t slab, int channel, std::span<const BrickLayer> layers);
  void store_slab(int32_t slab, int channel, std::span<const BrickLayer> layers);
  void check_bounds(const FitReport& result) const;
};

bccsplat_writer::bccsplat_writer(bccsplat_device* owner, const bccsplat_writer_options& o)
    : device(owner), progress(progress_callback(o.progress, o.progress_user)) {
  require_zero(o.set_mask, "bccsplat_writer_options.set_mask");
  for (size_t a = 0; a < 3; ++a)
    if (o.dims[a] == 0) fail(Code::invalid_argument, "writer: dims[", a, "] is 0");
  const double scale = o.scale == 0 ? 1 : o.scale, time_scale = o.time_scale == 0 ? 1 : o.time_scale;
  fit_options.lattice = choose(o.lattice, LatticeKind::d4star, 3, "lattice");
  fit_options.dims = {o.dims[0], o.dims[1], o.dims[2], o.dims[3]};
  fit_options.scale = scale, fit_options.time_scale = time_scale;
  fit_options.filter = choose(o.filter, Filter::kaiser8, 3, "filter");
  require_zero(o.reserved, "bccsplat_writer_options.reserved");
  fit_options.lowpass = o.lowpass != 0;
  if (fit_options.lowpass && fit_options.lattice == LatticeKind::cc)
    fail(Code::invalid_argument, "writer: a low-pass is of use on D4* and BCC only");
  fit_options.nonfinite = choose(o.nonfinite, NonFinite::error, 3, "nonfinite");
  fit_options.slab_layers = initial.slab_layers;
  const int32_t store = choose(o.store, BCCSPLAT_STORE_SAMPLES, 2, "store");
  coefficients = store == BCCSPLAT_STORE_COEFFICIENTS;
  if (o.partial < 0 || o.partial > BCCSPLAT_PARTIAL_APPEND)
    fail(Code::invalid_argument, "partial ", o.partial, " is not one of 0 .. 3");
  partial = o.partial;
  abs_error = o.abs_error, psnr = o.psnr, measure = o.measure;
  if (!(abs_error >= 0 && std::isfinite(abs_error)) || !(psnr >= 0 && std::isfinite(psnr)))
    fail(Code::invalid_argument, "writer: abs_error and psnr must be finite and not negative");
  if (measure < 0 || measure > BCCSPLAT_MEASURE_ALL)
    fail(Code::invalid_argument, "measure ", measure, " is not one of 0 .. 2");
  const bool bounded = abs_error > 0 || psnr > 0;
  if ((bounded || coefficients || measure == BCCSPLAT_MEASURE_ALL) && o.dims[3] == 0)
    fail(Code::invalid_argument,
         "writer: a bound, measuring, or coefficients need the number of frames in dims[3]");
  // Refuses impossible sizes before anything is written.
  initial.lattice = Lattice4::fit(
      fit_options.lattice, {o.dims[0], o.dims[1], o.dims[2], std::max(o.dims[3], 1u)}, scale, time_scale);
  if (o.lattice == BCCSPLAT_LATTICE_BCC && o.dims[3] != 1)
    fail(Code::invalid_argument, "writer: lattice BCC holds one frame; set dims[3] to 1 or choose D4STAR");
  initial.scale = scale, initial.time_scale = time_scale;
  initial.affine = read_affine(o.affine);
  initial.spatial_unit = text_or(o.spatial_unit, "");
  initial.time.unit = text_or(o.time_unit, "");
  if (o.recommended_kernel && *o.recommended_kernel)
    initial.recommended_kernel = make_kernel(o.recommended_kernel).name;
  else if (bounded || coefficients) // which must not depend on what a reader takes for the default
    initial.recommended_kernel = make_kernel("").name;
  if (coefficients) {
    const Kernel kernel = make_kernel(initial.recommended_kernel);
    initial.coefficient_parameters = kernel_parameters(kernel);
    initial.coefficient_kernel = kernel.name;
  }

  const uint32_t count = std::max(o.channel_count, 1u);
  if (o.channel_count > 0) require(o.channels, "channels");
  if (count > 1024) fail(Code::invalid_argument, "writer: ", count, " channels; at most 1024");
  for (uint32_t c = 0; c < count; ++c) {
    const auto in =
        read_struct(o.channel_count > 0 ? element(o.channels, c) : nullptr, "bccsplat_channel_options");
    ChannelInfo info;
    info.name = text_or(in.name, "value");
    info.unit = text_or(in.unit, "");
    if (info.name.empty()) fail(Code::invalid_argument, "channel ", c, ": the name is empty");
    for (const ChannelInfo& other : initial.channels)
      if (other.name == info.name) fail(Code::invalid_argument, "two channels are named ", info.name);
    if (in.set_mask & ~3u) fail(Code::invalid_argument, "channel ", info.name, ": unknown bits in set_mask");
    if (in.source_type < 0 || in.source_type > 9)
      fail(Code::invalid_argument, "channel ", info.name, ": source_type ", in.source_type);
    if (in.value_type < 0 || in.value_type > 4)
      fail(Code::invalid_argument, "channel ", info.name, ": value_type must be U8, U16, F16 or F32");
    if (!(in.air_threshold >= 0 && std::isfinite(in.air_threshold)) || !std::isfinite(in.air))
      fail(Code::invalid_argument, "channel ", info.name,
           ": air and air_threshold must be finite, the threshold >= 0");
    if ((in.set_mask & BCCSPLAT_CHANNEL_SET_RANGE) &&
        !(in.range[0] < in.range[1] && std::isfinite(in.range[0]) && std::isfinite(in.range[1])))
      fail(Code::invalid_argument, "channel ", info.name, ": range must be finite and rise");
    info.air = in.set_mask & BCCSPLAT_CHANNEL_SET_AIR ? static_cast<float>(in.air) : 0;
    info.threshold = static_cast<float>(in.air_threshold);
    initial.channels.push_back(std::move(info));
    channels.push_back(in);
  }
  added.assign(count, 0);
}

void bccsplat_writer::check_channel(uint32_t channel) const {
  if (channel >= channels.size())
    fail(Code::not_found, "channel ", channel, " of a writer with ", channels.size());
}

void bccsplat_writer::begin(Feeding kind, uint32_t first_channel, SourceType first_type) {
  if (feeding != Feeding::nothing && feeding != kind)
    fail(Code::wrong_state, "writer: frames and layers do not mix");
  if (fit) return;
  feeding = kind;
  fit_options.channels.clear();
  for (size_t c = 0; c < channels.size(); ++c) {
    const bccsplat_channel_options& in = channels[c];
    ChannelInfo& info = initial.channels[c];
    info.source_type = in.source_type       ? static_cast<SourceType>(in.source_type)
                       : c == first_channel ? first_type
                                            : SourceType::f32;
    FitChannel channel;
    channel.name = info.name;
    channel.threshold = info.threshold;
    const Quantiser own = quantiser_of_source(info.source_type, info.air);
    const auto type = in.value_type ? static_cast<ValueType>(in.value_type) : own.type;
    const bool integer = type == ValueType::u8 || type == ValueType::u16;
    if (in.value_step != 0 && !(in.set_mask & BCCSPLAT_CHANNEL_SET_RANGE))
      fail(Code::invalid_argument, "channel ", info.name, ": value_step needs the range of the values");
    if (coefficients) {
      const ValueType stored = in.value_type ? type : coefficient_type(info.source_type);
      if (in.set_mask & BCCSPLAT_CHANNEL_SET_RANGE) channel.range = Range{in.range[0], in.range[1]};
      if (stored != ValueType::f16 && stored != ValueType::f32)
        fail(Code::invalid_argument, "channel ", info.name, ": coefficients are stored as F16 or F32");
      // The samples they are made of are not rounded.
      channel.quantiser = quantiser_of_range(ValueType::f32, {}, info.air);
      info.type = stored, info.scale = 1, info.offset = static_cast<double>(info.air);
      fit_options.channels.push_back(std::move(channel));
      continue;
    }
    if (in.value_step != 0) {
      channel.range = Range{in.range[0], in.range[1]};
      channel.quantiser = quantiser_of_step(type, *channel.range, in.value_step, info.air, info.name);
    } else if (in.set_mask & BCCSPLAT_CHANNEL_SET_RANGE) {
      channel.range = Range{in.range[0], in.range[1]};
      channel.quantiser = quantiser_of_range(type, *channel.range, info.air);
    } else if (type == own.type) {
      channel.quantiser = own;
    } else if (integer && !(own.type == ValueType::u8 && type == ValueType::u16)) {
      fail(Code::invalid_argument, "channel ", info.name,
           ": storing this source as integers needs the range of its values");
    } else {
      channel.quantiser =
          own.type == ValueType::u8 && type == ValueType::u16 ? own : quantiser_of_range(type, {}, info.air);
      channel.quantiser.type = type;
    }
    info.type = channel.quantiser.type, info.scale = channel.quantiser.scale,
    info.offset = channel.quantiser.offset;
    fit_options.channels.push_back(std::move(channel));
  }
  context.emplace(device->context(progress));
  fit = std::make_unique<Fit>(
      fit_options,
      [this](int32_t slab, int channel, std::span<const BrickLayer> layers) {
        take_layers(slab, channel, layers);
      },
      *context);
}

// Once the fit is there.
void bccsplat_writer::start_measuring(bool frames_known) {
  const bool required = measuring_required();
  if (round_trip || given_up || (!required && measure == BCCSPLAT_MEASURE_DEFAULT)) return;
  if (!frames_known || fit_options.dims[3] == 0) {
    if (required)
      fail(Code::wrong_state,
           "writer: layers alone do not tell the source samples that a bound or measuring needs; "
           "give frames or a field");
    return;
  }
  std::vector<RoundTripChannel> list;
  for (ChannelInfo& c : initial.channels) {
    list.push_back({c.name, c.air, c.threshold, abs_error});
    if (abs_error > 0) c.residuals.step = RoundTrip::step(abs_error), c.residuals.bound = abs_error;
  }
  measuring([&] {
    round_trip = std::make_unique<RoundTrip>(
        fit->lattice(), std::move(list), initial.recommended_kernel, coefficients,
        measured_frames(fit_options.dims[3], required),
        [this](int channel, uint32_t frame, const FrameResiduals& residuals) {
          container->write_residuals(channel, frame, residuals);
        },
        *context);
  });
}

// What the fit hands out.
void bccsplat_writer::take_layers(int32_t slab, int channel, std::span<const BrickLayer> layers) {
  if (!coefficients) return store_slab(slab, channel, layers);
  prefiltered.resize(channels.size());
  auto& p = prefiltered[static_cast<size_t>(channel)];
  if (!p) {
    const ChannelInfo& c = initial.channels[static_cast<size_t>(channel)];
    const Quantiser quantiser{c.type, c.scale, c.offset, c.air};
    p = std::make_unique<Prefiltered>(fit->lattice(), quantiser, c.threshold, initial.coefficient_kernel);
  }
  for (BrickLayer& layer : p->maker.add(layers, *context)) {
    p->slab.push_back(std::move(layer));
    const bool last =
        p->next_slab * initial.slab_layers + static_cast<int32_t>(p->slab.size()) == fit->lattice().layers();
    if (!last && static_cast<int32_t>(p->slab.size()) < initial.slab_layers) continue;
    store_slab(p->next_slab++, channel, p->slab);
    p->slab.clear();
  }
}

void bccsplat_writer::store_slab(int32_t slab, int channel, std::span<const BrickLayer> layers) {
  make_container();
  container->write_slab(slab, channel, layers, *context);
  if (round_trip) measuring([&] { round_trip->add_layers(channel, layers); });
}

void bccsplat_writer::check_bounds(const FitReport& result) const {
  if (!(psnr > 0)) return;
  for (size_t c = 0; c < channels.size(); ++c) {
    const Range& range = result.channels[c].source_range;
    const SampleErrors& e = round_trip->errors(static_cast<int>(c));
    const double reached = e.all.psnr(range.high - range.low);
    if (reached < psnr)
      fail(Code::bound_not_met, "channel '", initial.channels[c].name, "': ", reached, " dB reached, ", psnr,
           " asked for; the largest difference is at frame ", e.frame, ", voxel (", e.voxel[0], ", ",
           e.voxel[1], ", ", e.voxel[2], "): ", e.got, " instead of ", e.expected,
           "; a smaller scale, lattice CC, more bits, or abs_error ",
           1.5 * (range.high - range.low) * std::pow(10, -psnr / 20), " would do");
  }
}

void bccsplat_writer::make_container() {
  if (container) return;
  initial.lattice = fit->lattice();
  Bcc4WriterOptions o;
  if (partial == BCCSPLAT_PARTIAL_APPEND) {
    o = appended();
  } else if (partial != BCCSPLAT_PARTIAL_DEFAULT) {
    o.journal = std::make_shared<Bcc4Journal>(path + ".journal", partial == BCCSPLAT_PARTIAL_RESUME);
    o.fingerprint = fingerprint();
  }
  container = std::make_unique<Bcc4Writer>(std::move(sink), initial, o);
}

// Of what decides the samples and stands nowhere in the file.
uint32_t bccsplat_writer::fingerprint() const {
  std::string text = concat(static_cast<int>(fit_options.filter), " ",
                            static_cast<int>(fit_options.nonfinite), " ", abs_error);
  if (fit_options.lowpass) text += " lowpass";
  for (const FitChannel& c : fit_options.channels) {
    text += concat(" ", c.threshold, " ", c.ringing);
    if (c.range) text += concat(" ", c.range->low, " ", c.range->high);
  }
  return crc32_of(std::as_bytes(std::span(text)));
}

// The slabs of the old file that new frames behind its last one do not touch.
Bcc4WriterOptions bccsplat_writer::appended() const {
  Bcc4WriterOptions o;
  const auto old = Bcc4Reader::open(open_file_source(path));
  const VolumeInfo& was = old->info();
  const Lattice4 &a = was.lattice, &b = initial.lattice;
  const auto differs = [&](const char* what) {
    fail(Code::wrong_state, path, ": ", what,
         " of its series and of the one to be appended differ; import all anew");
  };
  if (a.kind != b.kind || !(a.space == b.space) || a.time_step != b.time_step || a.is_static() ||
      !std::equal(a.dims.begin(), a.dims.begin() + 3, b.dims.begin()) ||
      was.slab_layers != initial.slab_layers)
    differs("the lattices");
  if (fit_options.dims[3] > 0 && a.dims[3] > b.dims[3]) differs("the numbers of frames");
  if (was.coefficient_kernel != initial.coefficient_kernel) differs("the kernels of coefficients");
  if (was.channels.size() != initial.channels.size()) differs("the channels");
  for (size_t c = 0; c < was.channels.size(); ++c) {
    const ChannelInfo &x = was.channels[c], &y = initial.channels[c];
    if (x.name != y.name || x.type != y.type || x.scale != y.scale || x.offset != y.offset ||
        x.air != y.air || x.threshold != y.threshold)
      differs("the channels");
  }
  // Coefficients hang on samples beyond the reach of the filter.
  if (!coefficients) {
    const int reach = filter_reach(fit_options.filter, std::max(1.0, a.time_step / a.layer_distance())) + 1 +
                      (fit_options.lowpass ? lowpass_time_reach(a) : 0);
    const double last = a.dims[3] - 1.0 - reach; // frame
    while (a.layer_frame((o.earlier_slabs + 1) * was.slab_layers - 1) <= last) ++o.earlier_slabs;
  }
  o.earlier = old;
  return o;
}

void bccsplat_writer::add_frame(uint32_t channel, double time, const bccsplat_box* boxes, uint64_t count) {
  if (feeding != Feeding::nothing && feeding != Feeding::frames) // `added` counts layers then
    fail(Code::wrong_state, "writer: frames and layers do not mix");
  const uint64_t frame = added[channel];
  if (!std::isfinite(time)) fail(Code::invalid_argument, "frame ", frame, ": the time is not finite");
  if (fit_options.dims[3] > 0 && frame >= fit_options.dims[3])
    fail(Code::wrong_state, "frame ", frame, ": the writer was made for ", fit_options.dims[3], " frames");
  if (frame == times.size()) {
    if (!times.empty() && !(time > times.back()))
      fail(Code::invalid_argument, "frame ", frame, ": time ", time, " does not rise above ", times.back(),
           " of the frame before");
    times.push_back(time);
  } else if (times[frame] != time) {
    fail(Code::invalid_argument, "frame ", frame, ": time ", time, " differs from ", times[frame],
         " of another channel");
  }
  std::vector<FrameBox> parts;
  parts.reserve(count);
  for (uint64_t i = 0; i < count; ++i) {
    const auto box = read_struct(element(boxes, i), "bccsplat_box");
    FrameBox part;
    if (box.type < 1 || box.type > 9)
      fail(Code::invalid_argument, "box ", i, ": type ", box.type, " is not a type of values");
    part.type = static_cast<SourceType>(box.type);
    part.data = box.data;
    require(box.data, "box.data");
    for (size_t a = 0; a < 3; ++a) {
      const int64_t n = fit_options.dims[a];
      if (box.begin[a] < 0 || box.dims[a] < 1 || box.begin[a] > n || box.dims[a] > n - box.begin[a])
        fail(Code::invalid_argument, "box ", i, " of frame ", frame, ": begin ", box.begin[a], " and dims ",
             box.dims[a], " along axis ", a, " do not fit into 0 .. ", n);
      part.begin[a] = box.begin[a], part.dims[a] = box.dims[a], part.stride[a] = box.stride_bytes[a];
    }
    parts.push_back(part);
  }
  begin(Feeding::frames, channel, parts.empty() ? SourceType::f32 : parts.front().type);
  start_measuring(true);
  if (round_trip)
    measuring([&] { round_trip->add_frame(static_cast<int>(channel), static_cast<uint32_t>(frame), parts); });
  fit->add_frame(static_cast<int>(channel), parts);
  ++added[channel];
  if (fit_options.dims[3] > 0)
    progress.report(static_cast<double>(*std::min_element(added.begin(), added.end())) / fit_options.dims[3] *
                    0.99);
  progress.check();
}

void bccsplat_writer::add_layer(uint32_t channel, int64_t layer, std::span<const float> samples) {
  if (fit_options.dims[3] == 0) fail(Code::wrong_state, "layers need the number of frames: set dims[3]");
  if (layer != static_cast<int64_t>(added[channel]))
    fail(Code::wrong_state, "layer ", layer, " given, ", added[channel], " is next");
  begin(Feeding::layers, channel, SourceType::f32);
  start_measuring(false);
  fit->add_layer(static_cast<int>(channel), static_cast<int32_t>(layer), samples);
  ++added[channel];
  progress.report(static_cast<double>(*std::min_element(added.begin(), added.end())) /
                  initial.lattice.layers() * 0.99);
  progress.check();
}

void bccsplat_writer::add_field(uint32_t channel, bccsplat_field_fn field, void* user) {
  if (fit_options.dims[3] == 0) fail(Code::wrong_state, "a field needs the number of frames: set dims[3]");
  if (added[channel] != 0) fail(Code::wrong_state, "channel ", channel, " has data already");
  begin(Feeding::layers, channel, SourceType::f32);
  start_measuring(true);
  const Lattice4& lattice = fit->lattice();
  std::vector<double> points;
  // Values at origin + step * (i, j, k), x fastest, at frame t.
  const auto ask = [&](const Vec3& origin, const Vec3& step, const Int3& n, double t) {
    std::vector<float> values(static_cast<size_t>(n[0]) * static_cast<size_t>(n[1]) *
                              static_cast<size_t>(n[2]));
    const Reservation memory(context->memory, values.size() * sizeof(float), "a layer of a field");
    const auto nx = static_cast<uint64_t>(n[0]), ny = static_cast<uint64_t>(n[1]);
    for (uint64_t first = 0; first < values.size(); first += field_points) {
      const uint64_t count = std::min<uint64_t>(field_points, values.size() - first);
      points.resize(4 * count);
      for (uint64_t i = 0; i < count; ++i) {
        const uint64_t at = first + i;
        points[4 * i] = origin[0] + step[0] * static_cast<double>(at % nx);
        points[4 * i + 1] = origin[1] + step[1] * static_cast<double>(at / nx % ny);
        points[4 * i + 2] = origin[2] + step[2] * static_cast<double>(at / nx / ny);
        points[4 * i + 3] = t;
      }
      if (field(user, count, points.data(), values.data() + first) != 0)
        fail(Code::cancelled, "the field of channel ", channel, " gave up");
      progress.check();
    }
    return values;
  };
  size_t next_frame = 0;
  for (int32_t layer = 0; layer < lattice.layers(); ++layer) {
    const double t = lattice.is_static() ? 0 : lattice.layer_frame(layer);
    for (;
         round_trip && next_frame < round_trip->frames().size() && round_trip->frames()[next_frame] <= t + 1;
         ++next_frame) {
      const uint32_t frame = round_trip->frames()[next_frame];
      const auto& d = lattice.dims;
      const std::vector<float> values =
          ask({}, {1, 1, 1},
              {static_cast<int32_t>(d[0]), static_cast<int32_t>(d[1]), static_cast<int32_t>(d[2])}, frame);
      FrameBox box;
      box.data = values.data(), box.dims = {d[0], d[1], d[2]};
      measuring([&] { round_trip->add_frame(static_cast<int>(channel), frame, {&box, 1}); });
    }
    const int coset = lattice.coset(layer);
    const Vec3 origin = lattice.site_position(coset, {0, 0, 0}),
               next = lattice.site_position(coset, {1, 1, 1});
    const Vec3 step{next[0] - origin[0], next[1] - origin[1], next[2] - origin[2]};
    fit->add_layer(static_cast<int>(channel), layer, ask(origin, step, lattice.space.dims(coset), t));
    ++added[channel];
    progress.report(static_cast<double>(*std::min_element(added.begin(), added.end())) / lattice.layers() *
                    0.99);
  }
}

bccsplat_writer_report bccsplat_writer::finish() {
  if (!fit) fail(Code::wrong_state, "writer: nothing was added");
  const FitReport result = fit->finish();
  make_container();
  VolumeInfo& info = container->info();
  info.lattice = result.lattice;
  if (feeding == Feeding::frames) {
    TimeMap map{
        .uniform = true, .first = times.front(), .step = 1, .times = {}, .unit = info.time.unit, .epoch = {}};
    if (times.size() > 1) map.step = (times.back() - times.front()) / static_cast<double>(times.size() - 1);
    for (size_t i = 0; i < times.size() && map.uniform; ++i)
      map.uniform = std::fabs(times[i] - map.at(i)) <= 1e-9 * map.step;
    if (!map.uniform) map.times = times;
    info.time = std::move(map);
  } else {
    info.time = initial.time;
  }
  check_bounds(result);
  info.sources = initial.sources;
  info.attributes = initial.attributes;

  bccsplat_writer_report report{};
  report.frames = result.lattice.dims[3];
  double squares = 0;
  for (size_t c = 0; c < result.channels.size(); ++c) {
    const FitChannelReport& r = result.channels[c];
    describe(r, info.channels[c]);
    report.cc_samples += info.cc_samples();
    report.cc_relevant += r.cc_relevant;
    report.sites_total += r.sites_total;
    report.sites_kept += r.sites_kept;
    report.holes += r.holes;
    report.clamped += r.clamped;
    report.nonfinite += r.nonfinite;
    report.coding_max = std::max(report.coding_max, r.coding_max);
    squares += r.coding_rmse * r.coding_rmse * static_cast<double>(r.sites_total);
    source_ranges.push_back(r.source_range);
    if (round_trip) report.corrected += round_trip->errors(static_cast<int>(c)).corrected;
    constexpr uint64_t bytes_of[] = {0, 1, 2, 2, 4, 2, 4, 8, 1, 4};
    report.bytes_source += info.cc_samples() * bytes_of[static_cast<size_t>(info.channels[c].source_type)];
  }
  const Bcc4Report written = container->finish(*context);
  if (report.sites_total > 0)
    report.coding_rmse = std::sqrt(squares / static_cast<double>(report.sites_total));
  if (round_trip) report.frames_measured = round_trip->frames().size();
  for (const ChannelInfo& c : info.channels)
    for (const BlockRef& ref : c.residuals.frames) report.bytes_corrections += ref.padded();
  report.slabs_reused = static_cast<uint32_t>(std::min<uint64_t>(written.slabs_reused, UINT32_MAX));
  report.bytes_file = written.bytes.file, report.bytes_runs = written.bytes.runs;
  report.bytes_values = written.bytes.values, report.bytes_index = written.bytes.index;
  finished = true;
  try {
    progress.report(1);
  } catch (const Error&) {
    // Too late to cancel: the file has its name.
  }
  return report;
}

namespace {

template<class MakeSink>
bccsplat_status create(bccsplat_device* device, const bccsplat_writer_options* options,
                       bccsplat_writer** writer, const MakeSink& make_sink) {
  return guard([&] {
    require(writer, "writer");
    *writer = nullptr;
    require(device, "device"), require(options, "options");
    const auto o = read_struct(options, "bccsplat_writer_options");
    auto result = std::make_unique<bccsplat_writer>(device, o);
    result->sink = make_sink(o, *result);
    *writer = result.release();
  });
}

} // namespace

extern "C" {

bccsplat_status bccsplat_writer_create(bccsplat_device* device, const char* path,
                                       const bccsplat_writer_options* options, bccsplat_writer** writer) {
  return create(device, options, writer, [&](const bccsplat_writer_options& o, bccsplat_writer& result) {
    require(path, "path");
    result.path = path;
    if (o.partial == BCCSPLAT_PARTIAL_APPEND) {
      if (!file_exists(path)) fail(Code::file_not_found, path, ": no file to append to");
      return create_file_sink(path, true);
    }
    return create_file_sink(path, o.overwrite != 0,
                            o.partial == BCCSPLAT_PARTIAL_DEFAULT ? Partial::removed
                            : o.partial == BCCSPLAT_PARTIAL_KEEP  ? Partial::kept
                                                                  : Partial::taken_over);
  });
}

bccsplat_status bccsplat_writer_create_stream(bccsplat_device* device, const bccsplat_write_stream* stream,
                                              const bccsplat_writer_options* options,
                                              bccsplat_writer** writer) {
  return create(device, options, writer, [&](const bccsplat_writer_options& o, bccsplat_writer&) {
    require(stream, "stream");
    if (o.partial != BCCSPLAT_PARTIAL_DEFAULT)
      fail(Code::unsupported,
           "writer: a stream's unfinished work is the host's own; partial must be DEFAULT");
    const auto s = read_struct(stream, "bccsplat_write_stream");
    require_zero(s.reserved, "bccsplat_write_stream.reserved");
    if (!s.write_at) fail(Code::invalid_argument, "bccsplat_write_stream.write_at is NULL");
    return create_stream_sink([s](uint64_t offset, std::span<const std::byte> bytes) {
      return s.write_at(s.user, offset, bytes.data(), bytes.size());
    });
  });
}

bccsplat_status bccsplat_writer_add_frame(bccsplat_writer* writer, uint32_t channel, double time,
                                          const bccsplat_box* boxes, uint64_t count) {
  return guard([&] {
    require(writer, "writer");
    if (count > 0) require(boxes, "boxes");
    writer->check_channel(channel);
    writer->step([&] { writer->add_frame(channel, time, boxes, count); });
  });
}

bccsplat_status bccsplat_writer_get_layer_geometry(const bccsplat_writer* writer, int64_t layer,
                                                   bccsplat_layer_geometry* geometry) {
  return guard([&] {
    require(writer, "writer");
    if (writer->fit_options.dims[3] == 0)
      fail(Code::wrong_state, "layers need the number of frames: set dims[3]");
    const Lattice4 lattice = Lattice4::fit(writer->fit_options.lattice, writer->fit_options.dims,
                                           writer->fit_options.scale, writer->fit_options.time_scale);
    if (layer < 0 || layer >= lattice.layers())
      fail(Code::not_found, "layer ", layer, " of ", lattice.layers());
    bccsplat_layer_geometry out{};
    out.coset = lattice.coset(static_cast<int32_t>(layer));
    const Int3 n = lattice.space.dims(out.coset);
    const Vec3 origin = lattice.site_position(out.coset, {0, 0, 0}),
               next = lattice.site_position(out.coset, {1, 1, 1});
    for (size_t a = 0; a < 3; ++a)
      out.dims[a] = n[a], out.origin[a] = origin[a], out.step[a] = next[a] - origin[a];
    out.frame = lattice.is_static() ? 0 : lattice.layer_frame(static_cast<int32_t>(layer));
    out.layer_count = lattice.layers();
    write_struct(geometry, out, "geometry");
  });
}

bccsplat_status bccsplat_writer_add_layer(bccsplat_writer* writer, uint32_t channel, int64_t layer,
                                          const float* samples, uint64_t count) {
  return guard([&] {
    require(writer, "writer"), require(samples, "samples");
    writer->check_channel(channel);
    writer->step([&] { writer->add_layer(channel, layer, {samples, count}); });
  });
}

bccsplat_status bccsplat_writer_add_field(bccsplat_writer* writer, uint32_t channel, bccsplat_field_fn field,
                                          void* user) {
  return guard([&] {
    require(writer, "writer");
    if (!field) fail(Code::invalid_argument, "field is NULL");
    writer->check_channel(channel);
    writer->step([&] { writer->add_field(channel, field, user); });
  });
}

bccsplat_status bccsplat_writer_get_error(const bccsplat_writer* writer, uint32_t channel, int64_t measured,
                                          bccsplat_error_report* error) {
  return guard([&] {
    require(writer, "writer");
    writer->check_channel(channel);
    if (!writer->finished) fail(Code::wrong_state, "writer: errors are known after finish");
    const RoundTrip* r = writer->round_trip.get();
    if (!r || measured < -1 || measured >= static_cast<int64_t>(r->frames().size()))
      fail(Code::not_found, "measured frame ", measured, " of ", r ? r->frames().size() : 0);
    const auto index = static_cast<int>(channel);
    const SampleErrors& e =
        measured < 0 ? r->errors(index) : r->frame_errors(index, static_cast<size_t>(measured));
    const Range& range = writer->source_ranges[channel];
    bccsplat_error_report out{};
    out.frame = measured < 0 ? e.frame : r->frames()[static_cast<size_t>(measured)];
    out.peak = range.high - range.low;
    out.samples = e.all.count, out.max_abs = e.all.largest, out.rmse = e.all.rms();
    out.psnr = e.all.psnr(out.peak);
    out.non_air_samples = e.non_air.count, out.non_air_max_abs = e.non_air.largest;
    out.non_air_rmse = e.non_air.rms(), out.non_air_psnr = e.non_air.psnr(out.peak);
    std::copy(e.voxel.begin(), e.voxel.end(), out.voxel);
    out.expected = e.expected, out.got = e.got;
    out.uncorrected_max_abs = e.uncorrected;
    out.corrected = e.corrected, out.lost = e.lost;
    write_struct(error, out, "error");
  });
}

bccsplat_status bccsplat_writer_set_times(bccsplat_writer* writer, double first, double step) {
  return guard([&] {
    require(writer, "writer");
    if (!std::isfinite(first) || !(step > 0 && std::isfinite(step)))
      fail(Code::invalid_argument, "times: first must be finite and step > 0");
    writer->initial.time.first = first, writer->initial.time.step = step;
  });
}

bccsplat_status bccsplat_writer_set_attribute(bccsplat_writer* writer, const char* key, const char* value) {
  return guard([&] {
    require(writer, "writer"), require(key, "key"), require(value, "value");
    if (!*key) fail(Code::invalid_argument, "the key is empty");
    auto& attributes = writer->initial.attributes;
    const auto it =
        std::find_if(attributes.begin(), attributes.end(), [&](const auto& a) { return a.first == key; });
    if (it != attributes.end())
      it->second = value;
    else
      attributes.emplace_back(key, value);
  });
}

bccsplat_status bccsplat_writer_add_source(bccsplat_writer* writer, const char* name, uint64_t bytes,
                                           uint32_t crc32) {
  return guard([&] {
    require(writer, "writer"), require(name, "name");
    writer->initial.sources.push_back({name, bytes, crc32});
  });
}

bccsplat_status bccsplat_writer_finish(bccsplat_writer* writer, bccsplat_writer_report* report) {
  return guard([&] {
    require(writer, "writer");
    check_output(report, "report");
    bccsplat_writer_report out{};
    writer->step([&] { out = writer->finish(); });
    if (report) write_struct(report, out, "report");
  });
}

void bccsplat_writer_retain(bccsplat_writer* writer) { retain(writer); }
void bccsplat_writer_release(bccsplat_writer* writer) { release(writer); }

} // extern "C"
