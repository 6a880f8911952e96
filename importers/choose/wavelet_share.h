// SPDX-License-Identifier: Apache-2.0
// How much of a bound on every sample wavelets may use up before corrections do the rest.
#pragma once

#include <vector>

#include "choose/series_writer.h"
#include "choose/watch.h"
#include "readers/scan.h"

namespace bcc4 {

// Returns the root mean square error, as a share of the bound, with which a sample of the series takes the
// fewest bytes: of noise nearly half of it, of a smooth series, whose few large errors are dear to correct, a
// seventh; 0, the library's own choice, where codes hold none of them. settings: of the series, with
// abs_error. air: by channel.
[[nodiscard]] double choose_wavelet_share(FrameReader& reader, const Device& device,
                                          const WriterSettings& settings,
                                          const std::vector<ChannelScan>& scans,
                                          const std::vector<double>& air, Watch& watch);

} // namespace bcc4
