#include <algorithm>
#include <array>
#include <cmath>

#include "api/writer.h"
#include "formats/bcc4/coding/deflate.h"

using namespace bccsplat;
using namespace bccsplat::api;

namespace {

constexpr uint32_t frames_of_some = 3;            // BCCSPLAT_MEASURE_SOME
constexpr int32_t end_layers = 4;                 // beyond each end of a series, more than a kernel's reach
constexpr int32_t fewest_layers = 8 * end_layers; // of a series that is predicted unasked: a quarter more

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

} // namespace

// Of the whole series, or of the frames that continue it.
std::vector<uint32_t> bccsplat_writer::measured_frames() const {
  const bool all = measuring_required();
  if (!all && measure == BCCSPLAT_MEASURE_DEFAULT) return {};
  const uint32_t first = continued ? fit_options.part->first_counted : 0,
                 frames = fit_options.dims[3] - first;
  std::vector<uint32_t> list;
  const uint32_t count = all ? frames : std::min(frames, frames_of_some);
  for (uint32_t i = 0; i < count; ++i)
    list.push_back(first + (all ? i : static_cast<uint32_t>(uint64_t{frames} * (2 * i + 1) / (2 * count))));
  return list;
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
  if (kind == Feeding::frames && !continued) fit_options.lead = lead();
  context.emplace(device->context(progress));
  fit = std::make_unique<Fit>(
      fit_options,
      [this](int32_t slab, int channel, std::span<const BrickLayer> layers) {
        take_layers(slab, channel, layers);
      },
      *context);
}

// A series that is appended to keeps the layers it has.
int32_t bccsplat_writer::lead() const {
  if (fit_options.dims[3] == 1) return 0;
  if (partial == BCCSPLAT_PARTIAL_APPEND)
    return Bcc4Reader::open(open_file_source(path))->info().lattice.lead;
  if (ends != BCCSPLAT_ENDS_DEFAULT) return ends == BCCSPLAT_ENDS_MIRROR ? 0 : end_layers;
  if (fit_options.lattice == LatticeKind::cc || fit_options.dims[3] == 0) return 0;
  const Lattice4 lattice =
      Lattice4::fit(fit_options.lattice, fit_options.dims, fit_options.scale, fit_options.time_scale);
  return lattice.layers() < fewest_layers ? 0 : end_layers;
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
  std::vector<uint32_t> frames = measured_frames();
  if (part)
    std::erase_if(frames,
                  [&](uint32_t f) { return f < part->fit.first_counted || f >= part->fit.end_counted; });
  const int32_t first_layer = continued ? fit_options.part->first_layer : part ? part->first_layer : 0;
  if (continued)
    std::erase_if(frames, [&](uint32_t f) {
      return layers_to_measure(fit->lattice(), initial.recommended_kernel, coefficients, f).begin <
             first_layer;
    });
  measuring([&] {
    round_trip = std::make_unique<RoundTrip>(
        fit->lattice(), std::move(list), initial.recommended_kernel, coefficients, std::move(frames),
        [this](int channel, uint32_t frame, const FrameResiduals& residuals) {
          store_residuals(channel, frame, residuals);
        },
        *context, first_layer);
  });
}

// Of what decides the samples and stands nowhere in the file.
uint32_t bccsplat_writer::series_fingerprint() const {
  std::string text = concat(static_cast<int>(fit_options.filter), " ",
                            static_cast<int>(fit_options.nonfinite), " ", abs_error);
  if (fit_options.lowpass) text += " lowpass";
  if (part) text += concat(" psnr ", psnr);
  if (fit_options.lead > 0) text += concat(" lead ", fit_options.lead);
  for (const FitChannel& c : fit_options.channels) {
    text += concat(" ", c.threshold, " ", c.ringing);
    if (c.range) text += concat(" ", c.range->low, " ", c.range->high);
  }
  return crc32_of(std::as_bytes(std::span(text)));
}

uint32_t bccsplat_writer::fingerprint() const {
  if (!part) return series_fingerprint();
  const std::array<uint32_t, 3> of_part{series_fingerprint(), part->fit.first_counted, part->fit.end_counted};
  return crc32_of(std::as_bytes(std::span(of_part)));
}
