// SPDX-License-Identifier: Apache-2.0
// What wavelets take of a sample of a series: beside samples that are kept as they are, and by how much of a
// bound they may use up before corrections do the rest.
#pragma once

#include <vector>

#include "choose/series_writer.h"
#include "series/scan.h"
#include "series/watch.h"

namespace bccsplat::series {

// Returns the root mean square error, as a share of the bound, with which a sample of the series takes the
// fewest bytes: of noise nearly half of it, of a smooth series, whose few large errors are dear to correct, a
// seventh; 0, the library's own choice, where codes hold none of them. settings: of the series, with
// abs_error. air: by channel.
[[nodiscard]] double choose_wavelet_share(FrameReader& reader, const Device& device,
                                          const WriterSettings& settings,
                                          const std::vector<ChannelScan>& scans,
                                          const std::vector<double>& air, Watch& watch);

// Returns whether the source's samples, as precise as they are, take fewer bytes than wavelets: where
// integers are to come back so well that these code noise. settings: of the store of wavelets.
[[nodiscard]] bool takes_less_exactly(FrameReader& reader, const Device& device,
                                      const WriterSettings& settings, const std::vector<ChannelScan>& scans,
                                      const std::vector<double>& air, Watch& watch);

} // namespace bccsplat::series
