// SPDX-License-Identifier: Apache-2.0
// Errors against the source, in words and as JSON with stable keys: of import and of verify.
#pragma once

#include <string>
#include <vector>

#include "tool/handles.h"
#include "tool/json_fwd.h"

namespace bcc4 {

// "max 0.12, RMSE 0.003, PSNR 51.2 dB".
[[nodiscard]] std::string error_text(const bccsplat_error_report& error);
// max_abs, rmse, psnr, samples_compared, peak, worst {frame, voxel, expected, got}, non_air {...}, corrected,
// uncorrected_max_abs, lost.
[[nodiscard]] Json error_json(const bccsplat_error_report& error);

// What a finished writer measured of its channels.
struct MeasuredErrors {
  std::vector<bccsplat_error_report> series;              // by channel
  std::vector<std::vector<bccsplat_error_report>> frames; // by channel, then measured frame
};
[[nodiscard]] MeasuredErrors measured_errors(const Writer& writer, size_t channels, uint64_t frames_measured);
// Adds what another writer measured of other samples of the same frames; peaks stay those of the first.
void add_errors(const MeasuredErrors& more, MeasuredErrors& all);
// Sets the range of the source, and the PSNR that follows.
void set_peak(bccsplat_error_report& error, double peak);

} // namespace bcc4
