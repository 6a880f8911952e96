// SPDX-License-Identifier: Apache-2.0
// Chooses a channel's codes from the type, range or step asked for, and refuses what they cannot hold.
// Measured errors are cut to a few digits, so that files do not depend on the instruction set.
#include "store/channel_info.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "base/error.h"
#include "fit/kept/packed_block.h"

namespace bccsplat {
namespace {

// Codes a caller-chosen step apart, one of them air itself.
Quantiser quantiser_of_step(ValueType type, const Range& range, double step, float air,
                            const std::string& name) {
  const double zero = air;
  const double low = std::min(range.low, zero), high = std::max(range.high, zero);
  const double below = std::ceil((zero - low) / step);
  const double codes = below + std::ceil((high - zero) / step) + 1; // one of them air itself
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

FitChannel code_channel(const ChannelSettings& settings, SourceType first, ChannelInfo& info) {
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
  return channel;
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
