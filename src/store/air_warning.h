// SPDX-License-Identifier: Apache-2.0
// Warns of air far from the values of a channel of which no site is air.
//
// A kernel brings a constant back to within a share of its distance from the base of the field, its ripple.
// Readers take a base among the values (formats/bcc4/field_base.h), but in the corrected parts of a series,
// whose writers do not know each other's values: there it is air, and where air is many times the range of
// the values away the ripple costs as many corrections. And floats are stored relative to air: far from it
// they have coarse steps.
#pragma once

#include <string>

#include "fit/fit.h"
#include "formats/bcc4/info.h"

namespace bccsplat {

// Empty where the values are near enough to air, or some sites are air.
[[nodiscard]] std::string air_warning(const ChannelInfo& channel, const FitChannelReport& counted);

} // namespace bccsplat
