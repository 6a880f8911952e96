// SPDX-License-Identifier: Apache-2.0
// Decides the type or step that each channel is stored in, so that a source's integers are codes and air is
// among them, and fills the options of the C API with it.
#include "choose/series_writer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace bccsplat::series {
namespace {

// The smallest and the largest value that a scaled source can have.
std::array<double, 2> scaled_range(const Channel& channel) {
  return visit_type(channel.precision, [&](auto zero) -> std::array<double, 2> {
    using Stored = decltype(zero);
    if constexpr (std::is_integral_v<Stored>) {
      const double a = static_cast<double>(std::numeric_limits<Stored>::lowest());
      const double b = static_cast<double>(std::numeric_limits<Stored>::max());
      const auto [low, high] = std::minmax({channel.step * a, channel.step * b});
      return {channel.offset + low, channel.offset + high};
    } else {
      return {-HUGE_VAL, HUGE_VAL}; // floats, and 64-bit integers read as such
    }
  });
}

// The value of the source nearest to `air`.
double nearest_scaled(const Channel& channel, double air) {
  const auto [low, high] = scaled_range(channel);
  const double code = std::nearbyint((std::clamp(air, low, high) - channel.offset) / channel.step);
  return channel.offset + channel.step * code;
}

} // namespace

std::optional<ScaledCoding> scaled_coding(const Channel& channel, const WriterSettings& settings) {
  if (!channel.scaled() || type_size(channel.precision) > 2) return std::nullopt;
  Channel plain = channel;
  plain.step = 0;
  ScaledCoding coding{stored_type(plain, settings), std::abs(channel.step), scaled_range(channel)};
  const double most = coding.type == BCCSPLAT_TYPE_U8 ? 255 : coding.type == BCCSPLAT_TYPE_U16 ? 65535 : 0;
  // The ends a quarter of a step inwards have the same codes, rounded or not.
  coding.range[0] += coding.step / 4, coding.range[1] -= coding.step / 4;
  const double air = static_cast<float>(air_of(channel, settings)); // as the library holds it
  const double codes = std::ceil((air - std::min(coding.range[0], air)) / coding.step) +
                       std::ceil((std::max(coding.range[1], air) - air) / coding.step);
  return codes <= most ? std::optional(coding) : std::nullopt;
}

double source_step(const Channel& c) {
  return c.scaled() ? std::fabs(c.step) : is_float(c.precision) ? 0 : 1;
}

bool has_cartesian(const std::string& kernel) {
  return kernel.find("24") == std::string::npos && kernel != "fine" && kernel != "gauss09";
}

int32_t stored_type(const Channel& channel, const WriterSettings& settings) {
  if (const auto scaled = scaled_coding(channel, settings)) return scaled->type;
  if (settings.quantize != BCCSPLAT_TYPE_DEFAULT) return settings.quantize;
  if (channel.scaled()) return BCCSPLAT_TYPE_F32;
  switch (channel.precision) {
  case Type::u8:
  case Type::i8:
    return BCCSPLAT_TYPE_U8;
  case Type::u16:
  case Type::i16:
    return BCCSPLAT_TYPE_U16;
  case Type::f16:
    return BCCSPLAT_TYPE_F16;
  default:
    return BCCSPLAT_TYPE_F32;
  }
}

namespace {

constexpr double kMostCodes = 65000; // of u16, a little room left
// Half of the codes on either side of air: values that come later hardly ever find none. A channel with more
// of them in its range has room for an eighth of it.
constexpr double kWideCodes = 8192;

} // namespace

bool has_wide_codes(double step, const ChannelScan& known) {
  return known.empty() || known.max - known.min <= kWideCodes * step;
}

StepCoding step_coding(double step, const ChannelScan& known, double air, int32_t nonfinite) {
  const double low = known.empty() ? air : std::min(known.min, air);
  const double high = known.empty() ? air : std::max(known.max, air);
  StepCoding coding{step, {low, std::max(high, low + step)}};
  // Clamped infinities become the ends of the range: no room beyond it.
  if (nonfinite != BCCSPLAT_NONFINITE_CLAMP) {
    const bool wide = has_wide_codes(step, known) && high - low <= 2 * kWideCodes * step;
    const double room = (high - low) / 8;
    coding.range = wide ? std::array{air - kMostCodes / 2 * step, air + kMostCodes / 2 * step}
                        : std::array{low - room, high + room};
  }
  return coding.range[1] - coding.range[0] <= kMostCodes * step * (1 + 1e-9) ? coding : StepCoding{};
}

std::vector<StepCoding> whole_steps(const std::vector<double>& widest, const SeriesDescription& series,
                                    const WriterSettings& settings, const std::vector<ChannelScan>& known) {
  std::vector<StepCoding> steps;
  for (size_t c = 0; c < series.channels.size(); ++c) {
    const Channel& channel = series.channels[c];
    const double unit = source_step(channel);
    const double step = unit == 0              ? widest[c]
                        : widest[c] < 2 * unit ? 0
                                               : std::floor(widest[c] / unit) * unit;
    steps.push_back(step > 0 ? step_coding(step, known[c], air_of(channel, settings), settings.nonfinite)
                             : StepCoding{});
  }
  const bool any = std::any_of(steps.begin(), steps.end(), [](const StepCoding& s) { return s.step > 0; });
  return any ? steps : std::vector<StepCoding>{};
}

double step_of(const WriterSettings& settings, size_t channel) {
  return channel < settings.steps.size() ? settings.steps[channel].step : 0;
}

bool needs_range(const Channel& channel, const WriterSettings& settings) {
  if (scaled_coding(channel, settings)) return false;
  if (settings.nonfinite == BCCSPLAT_NONFINITE_CLAMP && is_float(channel.type)) return true;
  if (settings.quantize != BCCSPLAT_TYPE_U8 && settings.quantize != BCCSPLAT_TYPE_U16) return false;
  WriterSettings source = settings;
  source.quantize = BCCSPLAT_TYPE_DEFAULT;
  return stored_type(channel, source) != settings.quantize || is_float(channel.type);
}

double air_of(const Channel& channel, const WriterSettings& settings) {
  if (settings.air) return *settings.air;
  const auto own = settings.own_air.find(channel.name);
  const double air = own == settings.own_air.end() ? channel.air : own->second;
  return channel.scaled() ? nearest_scaled(channel, air) : air;
}

namespace {

// Returns whether the sites of a Cartesian lattice are the samples in space, and its layers frames.
bool has_sites_at_samples(const WriterSettings& s, bool all_frames) {
  const auto distance = [&](size_t axis) {
    const double otherwise = axis == 3 ? s.time_scale : s.scale;
    return s.scales[axis] > 0 ? s.scales[axis] : otherwise > 0 ? otherwise : 1;
  };
  return s.lattice == BCCSPLAT_LATTICE_CC && distance(0) == 1 && distance(1) == 1 && distance(2) == 1 &&
         distance(3) == (all_frames ? 1 : std::round(distance(3)));
}

// Returns the kernel that gives the frames back that a Cartesian lattice keeps, unless one is asked for.
std::string kernel_of(const WriterSettings& s) {
  return s.kernel.empty() && has_sites_at_samples(s, false) ? "exact" : s.kernel;
}

// What a file says of a channel. Labels that are blended or rounded are none any more, and off the grid of
// the source there are none.
uint32_t kind_of(const WriterSettings& s, size_t channel) {
  if (channel >= s.labels.size() || s.store == BCCSPLAT_STORE_WAVELETS || !has_sites_at_samples(s, true))
    return 0;
  if (!s.labels[channel]) return BCCSPLAT_CHANNEL_QUANTITIES;
  const bool whole = s.quantize == BCCSPLAT_TYPE_DEFAULT && step_of(s, channel) == 0;
  return whole ? BCCSPLAT_CHANNEL_LABELS : 0;
}

void set_range(bccsplat_channel_options& options, double low, double high) {
  options.set_mask |= BCCSPLAT_CHANNEL_SET_RANGE;
  options.range[0] = low, options.range[1] = high;
}

// Without its texts. scan: of a channel whose range is needed.
bccsplat_channel_options channel_options(const Channel& channel, const WriterSettings& settings,
                                         const StepCoding& coding, const ChannelScan* scan) {
  auto options = sized<bccsplat_channel_options>();
  options.set_mask = BCCSPLAT_CHANNEL_SET_AIR;
  // Scaled integers are no whole numbers: who gives them back gives floats.
  options.source_type = channel.scaled() ? BCCSPLAT_TYPE_F32 : library_type(channel.precision);
  options.value_type = settings.quantize;
  options.air = air_of(channel, settings);
  options.air_threshold = settings.air_threshold;
  if (coding.step > 0) {
    options.value_type = BCCSPLAT_TYPE_U16;
    options.value_step = coding.step;
    set_range(options, coding.range[0], coding.range[1]);
  } else if (const auto scaled = scaled_coding(channel, settings)) {
    options.value_type = scaled->type;
    options.value_step = scaled->step;
    set_range(options, scaled->range[0], scaled->range[1]);
  } else if (needs_range(channel, settings)) {
    // Air must have a code of its own, and a range some width.
    const double low = scan->empty() ? options.air : std::min(scan->min, options.air);
    const double high = scan->empty() ? options.air : std::max(scan->max, options.air);
    set_range(options, low, high > low ? high : low + 1);
  }
  return options;
}

std::vector<bccsplat_channel_options> options_of_channels(const SeriesDescription& series,
                                                          const WriterSettings& settings,
                                                          const std::vector<ChannelScan>& scans) {
  std::vector<bccsplat_channel_options> channels;
  for (size_t c = 0; c < series.channels.size(); ++c) {
    channels.push_back(channel_options(series.channels[c], settings,
                                       c < settings.steps.size() ? settings.steps[c] : StepCoding{},
                                       c < scans.size() ? &scans[c] : nullptr));
    channels.back().set_mask |= kind_of(settings, c);
  }
  return channels;
}

bccsplat_writer_options plain_options(const WriterSettings& settings) {
  auto options = sized<bccsplat_writer_options>();
  options.lattice = settings.lattice;
  options.lowpass = settings.lowpass ? 1 : 0;
  options.ends = settings.ends;
  options.faces = settings.faces;
  options.periodic_axes = settings.periodic;
  options.scale = settings.scale;
  options.time_scale = settings.time_scale;
  std::copy(settings.scales.begin(), settings.scales.end(), options.scales);
  options.store = settings.store;
  options.levels = settings.levels;
  options.fixed_predictions = settings.fixed_predictions ? 1 : 0;
  options.nonfinite = settings.nonfinite;
  options.abs_error = settings.abs_error;
  options.psnr = settings.psnr;
  options.measure = settings.measure;
  options.overwrite = settings.overwrite;
  options.cancel_token = settings.cancel_token;
  return options;
}

} // namespace

ChosenOptions::ChosenOptions(const SeriesDescription& series, const WriterSettings& settings,
                             const std::vector<ChannelScan>& scans)
    : SeriesOptions(series, plain_options(settings), options_of_channels(series, settings, scans),
                    kernel_of(settings), settings.wavelet_errors, settings.abs_errors) {}

Writer create_writer(const Device& device, const SeriesDescription& series, const WriterSettings& settings,
                     const std::vector<ChannelScan>& scans, uint64_t frames,
                     const bccsplat_write_stream* stream) {
  ChosenOptions made(series, settings, scans);
  made.options.dims[3] = static_cast<uint32_t>(frames);
  if (stream) made.options.levels = 0; // who compares files of a stream looks at level 0
  const bccsplat_write_stream none = nowhere();
  bccsplat_writer* writer = nullptr;
  check(bccsplat_writer_create_stream(device.get(), stream ? stream : &none, &made.options, &writer), "");
  return Writer(writer);
}

} // namespace bccsplat::series
