// SPDX-License-Identifier: Apache-2.0
#include "tool/import/report.h"

#include <cmath>

#include "tool/json.h"

namespace bcc4 {
namespace {

std::string psnr_text(double psnr, double peak) {
  if (std::isinf(psnr) && psnr > 0) return "exact";
  if (!(peak > 0)) return "no PSNR of a constant";
  return concat("PSNR ", short_number(psnr, 4), " dB (peak ", short_number(peak), ")");
}

} // namespace

std::string error_text(const bccsplat_error_report& e) {
  if (e.samples == 0) return "nothing to compare";
  return concat("max ", short_number(e.max_abs), ", RMSE ", short_number(e.rmse), ", ",
                psnr_text(e.psnr, e.peak));
}

Json error_json(const bccsplat_error_report& e) {
  Json j{{"max_abs", e.max_abs}, {"rmse", e.rmse}, {"psnr", e.psnr}, {"samples_compared", e.samples}};
  j["peak"] = e.peak;
  j["worst"] = {{"frame", e.frame}, {"voxel", e.voxel}, {"expected", e.expected}, {"got", e.got}};
  j["non_air"] = {{"max_abs", e.non_air_max_abs},
                  {"rmse", e.non_air_rmse},
                  {"psnr", e.non_air_psnr},
                  {"samples_compared", e.non_air_samples}};
  j["corrected"] = e.corrected;
  j["uncorrected_max_abs"] = e.uncorrected_max_abs;
  j["lost"] = e.lost;
  return j;
}

MeasuredErrors measured_errors(const Writer& writer, size_t channels, uint64_t frames_measured) {
  MeasuredErrors out;
  if (frames_measured == 0) return out;
  out.frames.resize(channels);
  const auto get = [&](uint32_t channel, int64_t measured) {
    auto error = sized<bccsplat_error_report>();
    check(bccsplat_writer_get_error(writer.get(), channel, measured, &error), "");
    return error;
  };
  for (uint32_t c = 0; c < channels; ++c) {
    out.series.push_back(get(c, -1));
    for (uint64_t f = 0; f < frames_measured; ++f) out.frames[c].push_back(get(c, f));
  }
  return out;
}

} // namespace bcc4
