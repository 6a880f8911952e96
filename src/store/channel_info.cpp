// SPDX-License-Identifier: Apache-2.0
// Chooses a channel's codes from the type, range or step asked for, of samples or coefficients, and refuses
// what they cannot hold. Measured errors are cut to a few digits, so that files do not depend on the
// instruction set.
#include "store/channel_info.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "base/error.h"
#include "fit/kept/packed_block.h"

namespace bccsplat {
namespace {

// Returns how many codes a step apart hold a range, one of them air itself.
double codes_of_step(const Range& range, double step, float air) {
  const double zero = air;
  return std::ceil((zero - std::min(range.low, zero)) / step) +
         std::ceil((std::max(range.high, zero) - zero) / step) + 1;
}

// Codes a caller-chosen step apart, one of them air itself.
Quantiser quantiser_of_step(ValueType type, const Range& range, double step, float air,
                            const std::string& name) {
  const double zero = air;
  const double low = std::min(range.low, zero), high = std::max(range.high, zero);
  const double below = std::ceil((zero - low) / step), codes = codes_of_step(range, step, air);
  if (largest_code(type) == 0 || !(step > 0 && std::isfinite(step)) || !(codes <= largest_code(type) + 1.0))
    fail(Code::invalid_argument, "channel ", name, ": value_step ", step, " needs ", codes, " codes from ",
         low, " to ", high, "; the type has ", largest_code(type) + 1);
  return {type, step, zero - below * step, air};
}

bool is_integer(ValueType type) { return largest_code(type) > 0; }

Quantiser quantiser_of_samples(const ChannelSettings& settings, SourceType source) {
  const auto air = static_cast<float>(settings.air);
  const Quantiser own = quantiser_of_source(source, air);
  const ValueType type = settings.value_type.value_or(own.type);
  const bool spread = settings.range && settings.value_step == 0 && is_integer(type);
  if (settings.labels.value_or(false) && (spread || (type == ValueType::f16 && type != own.type)))
    fail(Code::unsupported, "channel ", settings.name,
         ": codes of a range and halves are near to labels at most; store them in their own type, or call "
         "them "
         "quantities");
  if (settings.value_step != 0)
    return quantiser_of_step(type, *settings.range, settings.value_step, air, settings.name);
  if (settings.range) return quantiser_of_range(type, *settings.range, air);
  if (type == own.type) return own;
  const bool widened = own.type == ValueType::u8 && type == ValueType::u16;
  if (is_integer(type) && !widened)
    fail(Code::invalid_argument, "channel ", settings.name,
         ": storing this source as integers needs the range of its values");
  Quantiser quantiser = widened ? own : quantiser_of_range(type, {}, air);
  quantiser.type = type;
  return quantiser;
}

} // namespace

FitChannel code_channel(const ChannelSettings& settings, SourceType first, bool coefficients,
                        ChannelInfo& info) {
  info.source_type = settings.source_type.value_or(first);
  FitChannel channel;
  channel.name = settings.name;
  channel.air = settings.air;
  channel.threshold = settings.threshold;
  channel.range = settings.range;
  if (settings.value_step != 0 && !settings.range)
    fail(Code::invalid_argument, "channel ", settings.name, ": value_step needs the range of the values");
  channel.quantiser = quantiser_of_samples(settings, info.source_type);
  static_cast<Quantiser&>(info) = channel.quantiser;
  if (settings.abs_error > 0) {
    info.residuals.step = RoundTrip::step(settings.abs_error), info.residuals.bound = settings.abs_error;
    info.residuals.local = true, info.residuals.shape = CorrectionShape::smooth;
  }
  channel.unit = packing_unit(channel.quantiser);
  if (!coefficients) return channel;
  static_cast<Quantiser&>(info) = quantiser_of_coefficients(channel.quantiser);
  if (info.type == ValueType::i32) channel.counted_step = info.scale;
  // The samples they are made of are not rounded.
  channel.quantiser = quantiser_of_range(ValueType::f32, {}, static_cast<float>(settings.air));
  return channel;
}

Quantiser code_channel_anew(const ChannelInfo& channel, bool coefficients, std::optional<ValueType> type,
                            double value_step) {
  const bool whole = !is_float(type.value_or(channel.type)) || (!type && value_step > 0);
  if (!whole) {
    if (value_step > 0)
      fail(Code::invalid_argument, "channel ", channel.name, ": value_step is for integer types");
    // Halves of samples may be stored as they are, not relative to air.
    if (!coefficients && type.value_or(channel.type) == channel.type)
      return static_cast<const Quantiser&>(channel);
    return quantiser_of_range(type.value_or(channel.type), {}, channel.air);
  }
  const bool spread = is_float(channel.type) && value_step == 0;
  if (spread) {
    const Quantiser samples = quantiser_of_range(*type, channel.source_range, channel.air);
    return coefficients ? quantiser_of_coefficients(samples) : samples;
  }
  const double step = value_step > 0 ? value_step : channel.scale;
  if (coefficients) {
    // Coefficients swing further than samples; 2^30 steps are there.
    if (!(codes_of_step(channel.source_range, step, channel.air) <= 0x1p26))
      fail(Code::invalid_argument, "channel ", channel.name, ": steps of ", step,
           " are too small for its range");
    return {ValueType::i32, step, channel.air, channel.air};
  }
  if (is_integer(channel.type) && step == channel.scale && type.value_or(channel.type) == channel.type)
    return static_cast<const Quantiser&>(channel);
  const double codes = codes_of_step(channel.source_range, step, channel.air);
  const ValueType smallest = codes <= 256 ? ValueType::u8 : ValueType::u16;
  const ValueType asked = type.value_or(channel.type);
  return quantiser_of_step(is_integer(asked) ? asked : smallest, channel.source_range, step, channel.air,
                           channel.name);
}

namespace {

// Three digits and a little, cut off: instruction sets measure alike but for the last bits of a float.
double few_digits(double error) {
  constexpr double digits = 4096;
  int exponent = 0;
  const double mantissa = std::frexp(error, &exponent);
  return std::ldexp(std::floor(mantissa * digits + 1e-3) / digits, exponent);
}

void add(MeasuredError& e, MeasuredError::Kind kind, const ErrorSum& sum, std::vector<MeasuredError>& list) {
  e.kind = kind, e.samples = sum.count;
  e.rmse = few_digits(sum.rms()), e.largest = few_digits(sum.largest);
  list.push_back(e);
}

} // namespace

void add_measured(const SampleErrors& errors, const Range& source, size_t channel, size_t frames,
                  std::vector<MeasuredError>& list) {
  MeasuredError e{.channel = static_cast<uint32_t>(channel),
                  .frames = static_cast<uint32_t>(frames),
                  .range = source.high - source.low};
  add(e, MeasuredError::stored, errors.bare, list);
  add(e, MeasuredError::corrected, errors.all, list);
}

void add_measured_level(const SampleErrors& errors, const Range& source, size_t channel, size_t level,
                        size_t frames, std::vector<MeasuredError>& list) {
  MeasuredError e{.channel = static_cast<uint32_t>(channel),
                  .level = static_cast<uint32_t>(level),
                  .frames = static_cast<uint32_t>(frames),
                  .range = source.high - source.low};
  add(e, MeasuredError::stored, errors.bare, list);
}

void sort_errors(std::vector<MeasuredError>& list) {
  std::sort(list.begin(), list.end(), [](const MeasuredError& a, const MeasuredError& b) {
    return std::tuple(a.channel, a.level, a.kind) < std::tuple(b.channel, b.level, b.kind);
  });
}

void describe_channel(const FitChannelReport& report, ChannelInfo& info) {
  info.source_range = report.source_range;
  info.histogram_range = report.samples.range();
  info.histogram = report.samples.bins(256);
  info.percentiles.clear();
  for (const double percent : {0.1, 1.0, 2.0, 5.0, 25.0, 50.0, 75.0, 95.0, 98.0, 99.0, 99.8, 99.9})
    info.percentiles.push_back({percent, report.samples.percentile(percent / 100)});
  info.frames = report.frames;
  info.cc_relevant = report.cc_relevant;
  info.clamped = report.clamped;
}

} // namespace bccsplat
