// Warns of air far from the values of a channel.
//
// A kernel brings a constant back to within a share of its distance from air, its ripple. Where that distance
// is many times the range of the values the ripple drowns them: a pressure of 101325 Pa in air 0.
#pragma once

#include <string>

#include "fit/fit.h"
#include "formats/bcc4/info.h"

namespace bccsplat {

// Empty where the values are near enough to air, or some sites are air.
[[nodiscard]] std::string air_warning(const ChannelInfo& channel, const FitChannelReport& counted);

} // namespace bccsplat
