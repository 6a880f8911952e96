// SPDX-License-Identifier: Apache-2.0
// Checksums that tell whether two writers would make the same samples.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "fit/fit.h"
#include "fit/resample/resampling_rules.h"
#include "formats/bcc4/info.h"
#include "store/settings.h"

namespace bccsplat {

// Returns the largest errors of the channels: one number where all have the same.
[[nodiscard]] std::string bounds_text(const WriterSettings& settings);

// The rules by which a version makes samples, and codes them as tiles; 0: the file has no tiles.
struct Rules {
  int resampling = resampling_rules, tiles = 0;
};

// Returns the checksum of every option that changes the samples but is not stored in the file. bounds: by
// bounds_text. psnr: of a part of a series, which is checked when the parts are joined. levels: the coarser
// ones.
[[nodiscard]] uint32_t options_checksum(const FitOptions& options, uint32_t levels, const std::string& bounds,
                                        std::optional<double> psnr, const Rules& rules = {});

// Returns the checksum of the same options for one part of the series.
[[nodiscard]] uint32_t part_checksum(uint32_t options, const FitPart& part);

// Returns the checksum of everything that must be equal for the parts of a series to fit together. options:
// their options_checksum.
[[nodiscard]] uint32_t series_checksum(VolumeInfo info, uint32_t options);

} // namespace bccsplat
