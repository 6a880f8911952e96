// SPDX-License-Identifier: Apache-2.0
#include "tool/import/report.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "readers/text.h"
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

namespace {

double joined_rmse(double a, uint64_t samples_a, double b, uint64_t samples_b) {
  const auto na = static_cast<double>(samples_a), nb = static_cast<double>(samples_b);
  return na + nb > 0 ? std::sqrt((a * a * na + b * b * nb) / (na + nb)) : 0;
}

// The first one is told where largest differences are equal.
bool is_worse(const bccsplat_error_report& a, const bccsplat_error_report& b) {
  const auto place = [](const bccsplat_error_report& e) {
    return std::tuple(e.frame, e.voxel[2], e.voxel[1], e.voxel[0]);
  };
  return a.max_abs > b.max_abs || (a.max_abs == b.max_abs && place(a) < place(b));
}

void add_error(const bccsplat_error_report& more, bccsplat_error_report& all) {
  if (more.samples > 0 && (all.samples == 0 || is_worse(more, all))) {
    all.frame = more.frame, all.max_abs = more.max_abs, all.expected = more.expected, all.got = more.got;
    std::copy(std::begin(more.voxel), std::end(more.voxel), all.voxel);
  }
  all.rmse = joined_rmse(all.rmse, all.samples, more.rmse, more.samples);
  all.non_air_rmse =
      joined_rmse(all.non_air_rmse, all.non_air_samples, more.non_air_rmse, more.non_air_samples);
  all.non_air_max_abs = std::max(all.non_air_max_abs, more.non_air_max_abs);
  all.uncorrected_max_abs = std::max(all.uncorrected_max_abs, more.uncorrected_max_abs);
  all.samples += more.samples, all.non_air_samples += more.non_air_samples;
  all.corrected += more.corrected, all.lost += more.lost;
}

} // namespace

void add_errors(const MeasuredErrors& more, MeasuredErrors& all) {
  if (all.series.empty()) {
    all = more;
    return;
  }
  for (size_t c = 0; c < more.series.size(); ++c) {
    add_error(more.series[c], all.series[c]);
    const size_t frames = std::min(more.frames[c].size(), all.frames[c].size());
    for (size_t f = 0; f < frames; ++f) add_error(more.frames[c][f], all.frames[c][f]);
  }
}

void set_peak(bccsplat_error_report& e, double peak) {
  e.peak = peak;
  const auto psnr = [&](double rmse) { return rmse > 0 ? 20 * std::log10(peak / rmse) : HUGE_VAL; };
  if (e.samples > 0) e.psnr = psnr(e.rmse);
  if (e.non_air_samples > 0) e.non_air_psnr = psnr(e.non_air_rmse);
}

} // namespace bcc4
