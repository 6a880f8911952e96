// SPDX-License-Identifier: Apache-2.0
// Puts the writer's report into words and JSON: bytes against the source, sites, what was clamped or missing,
// errors by channel, time and peak memory.
#include "tool/import/summary.h"

#include <algorithm>
#include <cstdio>

#include "readers/sequence.h"
#include "readers/text.h"
#include "tool/json.h"
#include "tool/system.h"

namespace bcc4 {
namespace {

// Returns the bytes of the values in their files: the library counts scaled integers as floats.
uint64_t value_bytes(const SeriesDescription& s, const bccsplat_writer_report& r) {
  uint64_t bytes = 0;
  for (const Channel& c : s.channels) bytes += r.cc_samples / s.channels.size() * type_size(c.precision);
  return bytes;
}

// Returns the part of a channel's samples in measured frames that was compared; 1 where all were that have a
// value.
double compared_part(const SeriesDescription& s, const ImportResult& import, size_t channel) {
  const bccsplat_error_report& e = import.errors.series[channel];
  const uint64_t all = s.dims[0] * s.dims[1] * s.dims[2] * import.report.frames_measured;
  uint64_t seen = e.samples + e.lost;
  for (const bccsplat_error_report& f : import.errors.frames[channel]) {
    const auto missing = import.nonfinite[channel].find(f.frame);
    if (missing != import.nonfinite[channel].end()) seen += missing->second;
  }
  return all == 0 || seen >= all ? 1 : static_cast<double>(e.samples) / static_cast<double>(all);
}

// Names the frames of which no value is there.
std::string empty_frames(const SeriesDescription& s, const ImportResult& import) {
  std::vector<int64_t> empty;
  for (const auto& of_channel : import.nonfinite)
    for (const auto& [frame, count] : of_channel)
      if (count == s.dims[0] * s.dims[1] * s.dims[2]) empty.push_back(static_cast<int64_t>(frame));
  std::sort(empty.begin(), empty.end());
  empty.erase(std::unique(empty.begin(), empty.end()), empty.end());
  return empty.empty() ? "" : concat(", all of frame ", range_text(empty, 1));
}

void print_errors(const SeriesDescription& s, const ImportResult& import) {
  const bccsplat_writer_report& r = import.report;
  std::printf("  coding error at the sites, by rounding and as air: max %s, RMSE %s\n",
              short_number(r.coding_max).c_str(), short_number(r.coding_rmse).c_str());
  for (size_t c = 0; c < import.errors.series.size(); ++c) {
    const bccsplat_error_report& e = import.errors.series[c];
    const double part = compared_part(s, import, c);
    const std::string boxes =
        part < 1 ? concat(", in boxes with ", short_number(100 * part, 2), " % of their samples") : "";
    std::printf("  error at the source samples, %s, measured on %llu of %llu frames%s: %s\n",
                s.channels[c].name.c_str(), static_cast<unsigned long long>(r.frames_measured),
                static_cast<unsigned long long>(r.frames), boxes.c_str(), error_text(e).c_str());
    if (e.samples == 0) continue;
    if (e.non_air_samples > 0 && e.non_air_samples < e.samples) {
      bccsplat_error_report inside = e;
      inside.samples = e.non_air_samples, inside.max_abs = e.non_air_max_abs;
      inside.rmse = e.non_air_rmse, inside.psnr = e.non_air_psnr;
      std::printf("    outside air: %s\n", error_text(inside).c_str());
    }
    const int digits = digits_apart(e.expected, e.got - e.expected, 6);
    std::printf("    worst: frame %llu, voxel (%llu, %llu, %llu): %s, source %s\n",
                static_cast<unsigned long long>(e.frame), static_cast<unsigned long long>(e.voxel[0]),
                static_cast<unsigned long long>(e.voxel[1]), static_cast<unsigned long long>(e.voxel[2]),
                short_number(e.got, digits).c_str(), short_number(e.expected, digits).c_str());
    if (e.corrected > 0)
      std::printf("    %llu samples corrected (%s), without it max %s\n",
                  static_cast<unsigned long long>(e.corrected),
                  byte_text(static_cast<double>(r.bytes_corrections)).c_str(),
                  short_number(e.uncorrected_max_abs).c_str());
    if (e.lost > 0)
      std::printf("    %llu samples beside missing data are missing in the file\n",
                  static_cast<unsigned long long>(e.lost));
  }
}

Json errors_json(const SeriesDescription& s, const ImportResult& import) {
  Json j{{"frames_measured", import.report.frames_measured},
         {"coding", {{"max_abs", import.report.coding_max}, {"rmse", import.report.coding_rmse}}}};
  j["channels"] = Json::array();
  for (size_t c = 0; c < import.errors.series.size(); ++c) {
    Json entry{{"name", s.channels[c].name}, {"compared_part", compared_part(s, import, c)}};
    entry.update(error_json(import.errors.series[c]));
    entry["frames"] = Json::array();
    for (const bccsplat_error_report& e : import.errors.frames[c])
      entry["frames"].push_back({{"frame", e.frame},
                                 {"max_abs", e.max_abs},
                                 {"rmse", e.rmse},
                                 {"psnr", e.psnr},
                                 {"corrected", e.corrected}});
    j["channels"].push_back(std::move(entry));
  }
  return j;
}

} // namespace

void print_summary(const SeriesDescription& s, const ImportResult& import, double seconds,
                   const std::string& output, const std::string& command_line) {
  const bccsplat_writer_report& r = import.report;
  const uint64_t values = value_bytes(s, r);
  uint64_t in = 0;
  for (const SourceFile& f : s.files) in += f.bytes;
  const auto ratio = [](uint64_t a, uint64_t b) {
    return static_cast<double>(a) / static_cast<double>(std::max<uint64_t>(1, b));
  };
  std::printf("%s: %s of values (%s on disk) -> %s, ratio %s (%s to the source files)\n", output.c_str(),
              byte_text(static_cast<double>(values)).c_str(), byte_text(static_cast<double>(in)).c_str(),
              byte_text(static_cast<double>(r.bytes_file)).c_str(),
              short_number(ratio(values, r.bytes_file), 3).c_str(),
              short_number(ratio(in, r.bytes_file), 3).c_str());
  if (import.given.first > 0 && r.frames > import.given.end - import.given.first)
    std::printf("  of %llu frames, %llu to %llu were read\n", static_cast<unsigned long long>(r.frames),
                static_cast<unsigned long long>(import.given.first),
                static_cast<unsigned long long>(import.given.end - 1));
  else if (import.given.end - import.given.first > r.frames)
    std::printf("  a part: %llu frames, made of frames %llu to %llu\n",
                static_cast<unsigned long long>(r.frames),
                static_cast<unsigned long long>(import.given.first),
                static_cast<unsigned long long>(import.given.end - 1));
  std::printf("  %llu samples -> %llu sites (%s), %llu stored (%s %%)\n",
              static_cast<unsigned long long>(r.cc_samples), static_cast<unsigned long long>(r.sites_total),
              short_number(ratio(r.sites_total, r.cc_samples), 4).c_str(),
              static_cast<unsigned long long>(r.sites_kept),
              short_number(100 * ratio(r.sites_kept, r.sites_total + r.sites_outside), 4).c_str());
  const bool doubles =
      std::any_of(s.channels.begin(), s.channels.end(), [](const Channel& c) { return c.type == Type::f64; });
  if (r.nonfinite > 0)
    std::printf("  %llu source values were not finite%s%s\n", static_cast<unsigned long long>(r.nonfinite),
                doubles ? " or beyond 32-bit floats" : "", empty_frames(s, import).c_str());
  if (r.clamped > 0)
    std::printf("  %llu values, of the source or by the filter beside edges, clamped to the range of the "
                "stored type\n",
                static_cast<unsigned long long>(r.clamped));
  print_errors(s, import);
  std::printf("  %s s, %s MB/s, peak memory %s\n", short_number(seconds, 3).c_str(),
              short_number(static_cast<double>(values) / std::max(seconds, 1e-9) / 1e6, 3).c_str(),
              byte_text(static_cast<double>(peak_memory())).c_str());
  std::printf("  again: %s\n", command_line.c_str());
}

Json bytes_json(const bccsplat_writer_report& r) {
  return {{"source", r.bytes_source}, {"file", r.bytes_file},   {"runs", r.bytes_runs},
          {"values", r.bytes_values}, {"index", r.bytes_index}, {"corrections", r.bytes_corrections}};
}

Json summary_json(const SeriesDescription& s, const ImportResult& import, double seconds) {
  const bccsplat_writer_report& r = import.report;
  Json bytes = bytes_json(r);
  bytes["source"] = value_bytes(s, r);
  return {{"frames", r.frames},
          {"cc_samples", r.cc_samples},
          {"cc_relevant", r.cc_relevant},
          {"sites_total", r.sites_total},
          {"sites_outside", r.sites_outside},
          {"sites_kept", r.sites_kept},
          {"holes", r.holes},
          {"clamped", r.clamped},
          {"nonfinite", r.nonfinite},
          {"bytes", bytes},
          {"error", errors_json(s, import)},
          {"seconds", seconds},
          {"peak_memory", peak_memory()}};
}

} // namespace bcc4
