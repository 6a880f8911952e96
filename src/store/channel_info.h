// SPDX-License-Identifier: Apache-2.0
// What a file says of a channel: how its samples are stored, as its settings and its source demand, and what
// the fit counted.
#pragma once

#include "fit/fit.h"
#include "store/round_trip.h"
#include "store/settings.h"

namespace bccsplat {

// first: type of the first box, where the settings name no type. Sets what `info` says of the source and of
// the coding, and returns what the fit is to do with the channel. Throws invalid_argument for settings that
// contradict each other.
[[nodiscard]] FitChannel code_channel(const ChannelSettings& settings, SourceType first, ChannelInfo& info);

// Adds what was measured of a channel, its source range given, over so many frames: the lattice alone and
// with corrections.
void add_measured(const SampleErrors& errors, const Range& source, size_t channel, size_t frames,
                  std::vector<MeasuredError>& list);
// The same of a level without corrections.
void add_measured_level(const SampleErrors& errors, const Range& source, size_t channel, size_t level,
                        size_t frames, std::vector<MeasuredError>& list);
// Puts them in the order that a file has them in.
void sort_errors(std::vector<MeasuredError>& list);

// Completes what `info` says about the source: ranges, histogram, percentiles, frames, cc_relevant, clamped.
void describe_channel(const FitChannelReport& report, ChannelInfo& info);

} // namespace bccsplat
