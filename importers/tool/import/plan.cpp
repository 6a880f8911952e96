// SPDX-License-Identifier: Apache-2.0
// Prints a plan as lines with a key before each, and makes JSON of it with the same facts. What chooses,
// searches and measures makes lines and JSON of its own.
#include "tool/import/plan.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "readers/text.h"
#include "tool/import/choice_json.h"
#include "tool/import/choice_text.h"
#include "tool/import/report.h"
#include "tool/json.h"

namespace bcc4 {
namespace {

template<class... Parts> void line(const char* key, const Parts&... parts) {
  std::printf("  %-10s %s\n", key, concat(parts...).c_str());
}

bool uniform(const std::vector<double>& t) {
  if (t.size() < 3) return true;
  const double step = (t.back() - t.front()) / static_cast<double>(t.size() - 1);
  for (size_t i = 0; i < t.size(); ++i)
    if (std::abs(t[i] - (t.front() + static_cast<double>(i) * step)) > 1e-6 * step) return false;
  return true;
}

// Eight digits are enough to recognise a transform.
std::string numbers_text(std::initializer_list<double> numbers) {
  std::string text;
  for (const double n : numbers) text += (text.empty() ? "" : " ") + short_number(n, 8);
  return text;
}

std::string affine_text(const std::array<double, 16>& m) {
  const bool diagonal = m[1] == 0 && m[2] == 0 && m[4] == 0 && m[6] == 0 && m[8] == 0 && m[9] == 0;
  if (diagonal)
    return concat("spacing ", numbers_text({m[0], m[5], m[10]}), ", origin ",
                  numbers_text({m[3], m[7], m[11]}));
  std::string text;
  for (size_t r = 0; r < 3; ++r)
    text += concat(r > 0 ? " " : "", "(", numbers_text({m[4 * r], m[4 * r + 1], m[4 * r + 2], m[4 * r + 3]}),
                   ")");
  return text;
}

std::string percent(uint64_t part, uint64_t whole) {
  return whole == 0
             ? "-"
             : concat(short_number(100.0 * static_cast<double>(part) / static_cast<double>(whole), 4), " %");
}

// What a store of wavelets promises, and, where nothing was asked for, how to ask.
std::string bound_text(const ErrorBound& bound) {
  constexpr double percents = 100;
  if (bound.share == 0)
    return bound.abs > 0 ? concat("no sample off by more than ", bound.abs) : concat(bound.psnr, " dB");
  return concat(bound.psnr, " dB outside air and no sample off by more than ",
                short_number(percents * bound.share, 2),
                " % of the range; more or less with --psnr or --abs, half the sites and no bound with "
                "--density .5");
}

int32_t type_in_file(const ImportPlan& plan, size_t c) {
  return step_of(plan.settings, c) > 0 ? BCCSPLAT_TYPE_U16
                                       : stored_type(plan.series.channels[c], plan.settings);
}

} // namespace

uint64_t cc_samples(const SeriesDescription& s) {
  return s.dims[0] * s.dims[1] * s.dims[2] * s.dims[3] * s.channels.size();
}

std::string times_text(const SeriesTimes& times) {
  const auto& t = times.values;
  const std::string unit = times.unit.empty() ? "" : " " + times.unit;
  if (t.size() == 1) return concat(t[0], unit, ", one frame");
  if (uniform(t))
    return concat(t.front(), " to ", t.back(), unit, ", ", t.size(), " frames, step ",
                  short_number((t.back() - t.front()) / static_cast<double>(t.size() - 1), 8));
  return concat(t.front(), " to ", t.back(), unit, ", ", t.size(), " frames, uneven");
}

// Prints which axes of space are unevenly spaced.
void print_places(const SeriesDescription& s) {
  for (size_t a = 0; a < s.places.size(); ++a)
    if (const std::vector<double>& at = s.places[a].coordinates; !at.empty())
      line(concat("  ", "xyz"[a]).c_str(), at.size(), " uneven places, ", short_number(at.front(), 7), " to ",
           short_number(at.back(), 7), s.places[a].unit.empty() ? "" : " ", s.places[a].unit);
}

void print_plan(const ImportPlan& plan, const DryRun& run) {
  const SeriesDescription& s = plan.series;
  uint64_t bytes = 0;
  for (const SourceFile& f : s.files) bytes += f.bytes;
  std::printf("%s%s\n", s.files.front().path.c_str(),
              s.files.size() > 1 ? concat(" and ", s.files.size() - 1, " more").c_str() : "");
  line("format", s.format, ", ", s.files.size(), s.files.size() == 1 ? " file, " : " files, ",
       byte_text(static_cast<double>(bytes)));
  line("samples", s.dims[0], " x ", s.dims[1], " x ", s.dims[2], ", ", s.dims[3],
       s.dims[3] == 1 ? " frame" : " frames");
  line("axes", s.axes);
  line("space", affine_text(s.affine), s.spatial_unit.empty() ? "" : " " + s.spatial_unit, " (",
       s.affine_origin, ")");
  print_places(s);
  line("times", times_text(s.times), " (", s.times.origin, ")");
  for (const std::string& gap : s.gaps) line("gap", gap);
  for (size_t c = 0; c < s.channels.size(); ++c) {
    const Channel& channel = s.channels[c];
    std::string text =
        concat(channel.name, ": ", type_name(channel.precision), " stored as ",
               value_type_name(type_in_file(plan, c)), ", air ", air_of(channel, plan.settings));
    if (plan.settings.air_threshold > 0) text += concat(" +- ", plan.settings.air_threshold);
    if (!plan.scans.empty()) {
      const ChannelScan& scan = plan.scans[c];
      if (!scan.empty()) text += concat(", range ", scan.min, " to ", scan.max);
      text += concat(", ", percent(scan.samples - scan.relevant, scan.samples), " air");
      if (scan.nonfinite > 0)
        text += concat(", ", scan.nonfinite, " not finite", scan.beyond > 0 ? " or beyond 32-bit floats" : "",
                       ", the first in frame ", scan.first_frame, " at voxel (", scan.first_voxel[0], ", ",
                       scan.first_voxel[1], ", ", scan.first_voxel[2], ")");
    }
    line(c == 0 ? "values" : "", text);
  }
  for (const std::string& note : s.notes) line("note", note);
  if (run.turn && run.turn->leads_to_first())
    line("ends",
         "the last frame is as near to the first as frames are to the next: if the series goes round, as "
         "heart beats and climatologies do, --ends periodic");
  for (size_t a = 0; a < run.round.size(); ++a)
    if (run.round[a] && run.round[a]->leads_to_first())
      line("faces",
           concat("the last samples along ", "xy"[a],
                  " are as near to the first as samples are to the next: if they go round, as longitude "
                  "does, --periodic ",
                  "xy"[a]));
  if (plan.spectra) {
    const auto lines = spectrum_lines(plan.spectra->plain);
    for (size_t i = 0; i < lines.size(); ++i) line(i == 0 ? "bandwidth" : "", lines[i]);
    if (const std::string text = motion_text(plan.motion, plan.spectra->plain); !text.empty())
      line("motion", text);
  }
  if (plan.choice) {
    const auto lines = choice_lines(*plan.choice, s);
    for (size_t i = 0; i < lines.size(); ++i) line(i == 0 ? "chosen" : "", lines[i]);
  } else if (plan.still) {
    line("chosen",
         "bcc, as of any single frame: 0.7 of the samples, and lossy at edges; --lattice cc keeps every "
         "sample as it is, --psnr or --abs the error you say");
  }
  if (plan.wavelets) line("chosen", "wavelets, ", bound_text(*plan.wavelets));
  if (plan.search)
    line("coding", coding_text(plan.search->chosen(), s), " (the smallest of ", plan.search->tried.size(),
         " tried on ", plan.search->sampled_frames, " frames)");
  if (const std::string text = levels_text(plan.levels, plan.settings.levels); !text.empty())
    line("levels", text);
  if (run.estimate) {
    const ImportEstimate& e = *run.estimate;
    line("lattice", cc_samples(s), " samples -> ", e.sites, " sites (",
         short_number(static_cast<double>(e.sites) / static_cast<double>(cc_samples(s)), 4), ")");
    line("estimate", byte_text(e.bytes_file), " on disk, ", byte_text(e.bytes_memory), " of memory, ",
         short_number(e.seconds, 2), " s (from ", e.sampled_frames,
         e.sampled_frames == 1 ? " frame)" : " frames)");
    for (size_t c = 0; c < e.errors.size(); ++c)
      line(c == 0 ? "error" : "", s.channels[c].name, ": ", error_text(e.errors[c]),
           " at the source samples");
  }
  std::fflush(stdout);
}

Json plan_json(const ImportPlan& plan, const DryRun& run) {
  const SeriesDescription& s = plan.series;
  Json j;
  j["format"] = s.format;
  j["files"] = Json::array();
  for (const SourceFile& f : s.files) j["files"].push_back({{"path", f.path}, {"bytes", f.bytes}});
  j["dims"] = s.dims;
  j["axes"] = s.axes;
  j["affine"] = matrix_json(s.affine.data());
  j["affine_origin"] = s.affine_origin;
  j["spatial_unit"] = s.spatial_unit;
  if (has_coordinates(s))
    for (const Places& p : s.places)
      j["places"].push_back({{"unit", p.unit}, {"down", p.down}, {"coordinates", p.coordinates}});
  j["times"] = {{"count", s.times.values.size()},     {"first", s.times.values.front()},
                {"last", s.times.values.back()},      {"unit", s.times.unit},
                {"uniform", uniform(s.times.values)}, {"origin", s.times.origin}};
  j["gaps"] = s.gaps;
  j["channels"] = Json::array();
  for (size_t c = 0; c < s.channels.size(); ++c) {
    const Channel& channel = s.channels[c];
    Json entry{{"name", channel.name},
               {"source_type", type_name(channel.precision)},
               {"value_type", value_type_name(type_in_file(plan, c))},
               {"air", air_of(channel, plan.settings)},
               {"air_threshold", plan.settings.air_threshold}};
    if (!plan.scans.empty()) {
      const ChannelScan& scan = plan.scans[c];
      entry["range"] = scan.empty() ? Json() : Json{scan.min, scan.max};
      entry["relevant"] = scan.relevant;
      entry["nonfinite"] = scan.nonfinite;
    }
    j["channels"].push_back(std::move(entry));
  }
  j["cc_samples"] = cc_samples(s);
  j["levels"] = plan.settings.levels;
  if (run.estimate) {
    const ImportEstimate& e = *run.estimate;
    j["sites_total"] = e.sites;
    j["estimate"] = {{"frames", e.sampled_frames},
                     {"bytes_file", std::llround(e.bytes_file)},
                     {"bytes_memory", std::llround(e.bytes_memory)},
                     {"seconds", e.seconds}};
    j["estimate"]["error"] = Json::array();
    for (const bccsplat_error_report& error : e.errors) j["estimate"]["error"].push_back(error_json(error));
  }
  if (plan.spectra) j["spectrum"] = spectrum_json(plan.spectra->plain);
  if (plan.motion) j["motion"] = *plan.motion;
  if (plan.choice) j["choice"] = choice_json(*plan.choice, s);
  if (const auto& b = plan.wavelets)
    j["wavelets"] = {{"psnr", b->psnr}, {"abs", b->abs}, {"share_of_range", b->share}};
  if (plan.search) j["coding"] = search_json(*plan.search, s);
  if (run.turn) j["turn"] = turn_json(*run.turn);
  for (size_t a = 0; a < run.round.size(); ++a)
    if (run.round[a]) j["round"][std::string(1, "xy"[a])] = turn_json(*run.round[a]);
  j["notes"] = s.notes;
  j["warnings"] = s.warnings;
  return j;
}

} // namespace bcc4
