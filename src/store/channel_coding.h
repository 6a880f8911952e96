// How the samples of a channel are stored: the type, scale and offset that its settings and its source lead
// to.
#pragma once

#include "fit/fit.h"
#include "store/settings.h"

namespace bccsplat {

// first: type of the first box, where the settings name no type. Sets what `info` says of the source and of
// the coding, and returns what the fit is to do with the channel. Throws invalid_argument for settings that
// contradict each other.
[[nodiscard]] FitChannel code_channel(const ChannelSettings& settings, SourceType first, bool coefficients,
                                      ChannelInfo& info);

} // namespace bccsplat
