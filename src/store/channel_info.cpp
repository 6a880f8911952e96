#include "store/channel_info.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace bccsplat {
namespace {

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

// Coefficients of eight bits and halves fit a half, others need a float.
ValueType coefficient_type(SourceType source) {
  return source == SourceType::u8 || source == SourceType::i8 || source == SourceType::f16 ? ValueType::f16
                                                                                           : ValueType::f32;
}

bool is_integer(ValueType type) { return largest_code(type) > 0; }

Quantiser quantiser_of_samples(const ChannelSettings& settings, SourceType source) {
  const Quantiser own = quantiser_of_source(source, settings.air);
  const ValueType type = settings.value_type.value_or(own.type);
  if (settings.value_step != 0)
    return quantiser_of_step(type, *settings.range, settings.value_step, settings.air, settings.name);
  if (settings.range) return quantiser_of_range(type, *settings.range, settings.air);
  if (type == own.type) return own;
  const bool widened = own.type == ValueType::u8 && type == ValueType::u16;
  if (is_integer(type) && !widened)
    fail(Code::invalid_argument, "channel ", settings.name,
         ": storing this source as integers needs the range of its values");
  Quantiser quantiser = widened ? own : quantiser_of_range(type, {}, settings.air);
  quantiser.type = type;
  return quantiser;
}

} // namespace

FitChannel code_channel(const ChannelSettings& settings, SourceType first, bool coefficients,
                        ChannelInfo& info) {
  info.source_type = settings.source_type.value_or(first);
  FitChannel channel;
  channel.name = settings.name;
  channel.threshold = settings.threshold;
  channel.range = settings.range;
  if (settings.value_step != 0 && !settings.range)
    fail(Code::invalid_argument, "channel ", settings.name, ": value_step needs the range of the values");
  if (coefficients) {
    info.type = settings.value_type.value_or(coefficient_type(info.source_type));
    if (is_integer(info.type))
      fail(Code::invalid_argument, "channel ", settings.name, ": coefficients are stored as F16 or F32");
    info.scale = 1, info.offset = static_cast<double>(settings.air);
    // The samples they are made of are not rounded.
    channel.quantiser = quantiser_of_range(ValueType::f32, {}, settings.air);
    return channel;
  }
  channel.quantiser = quantiser_of_samples(settings, info.source_type);
  static_cast<Quantiser&>(info) = channel.quantiser;
  return channel;
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
