// SPDX-License-Identifier: Apache-2.0
// Prints a plan as lines with a key before each, and makes JSON of it with the same facts. What chooses,
// searches and measures makes lines and JSON of its own.
#include "tool/import/plan.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "readers/text.h"
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

// What is known of a channel; null: its frames were not all read.
const Json* scan_of(const ImportPlan& plan, size_t c) {
  const auto channels = plan.found.find("channels");
  return channels == plan.found.end() ? nullptr : &channels->at(c);
}

std::string scan_text(const Json& scan) {
  const auto count = [&](const char* key) { return scan.at(key).get<uint64_t>(); };
  std::string text;
  if (const Json& range = scan.at("range"); !range.is_null())
    text += concat(", range ", range[0].get<double>(), " to ", range[1].get<double>());
  text += concat(", ", percent(count("samples") - count("relevant"), count("samples")), " air");
  if (const auto voxel = scan.at("first_voxel").get<std::array<uint64_t, 3>>(); count("nonfinite") > 0)
    text += concat(", ", count("nonfinite"), " not finite",
                   count("beyond") > 0 ? " or beyond 32-bit floats" : "", ", the first in frame ",
                   count("first_frame"), " at voxel (", voxel[0], ", ", voxel[1], ", ", voxel[2], ")");
  return text;
}

Json turn_json(const Turn& turn) {
  return {{"last_to_first", turn.last_to_first},
          {"to_next", turn.to_next},
          {"across", turn.across},
          {"periodic", turn.leads_to_first()}};
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
    const bccsplat_channel_options& stored = plan.settings().values[c];
    std::string text = concat(channel.name, ": ", type_name(channel.precision), " stored as ",
                              value_type_name(stored_type(stored)), ", air ", stored.air);
    if (stored.air_threshold > 0) text += concat(" +- ", stored.air_threshold);
    if (const Json* scan = scan_of(plan, c)) text += scan_text(*scan);
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
  std::string last; // lines of one key have it once
  for (const auto& [key, text] : choice_lines(plan)) line(key == last ? "" : (last = key).c_str(), text);
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
               {"value_type", value_type_name(stored_type(plan.settings().values[c]))},
               {"air", plan.settings().values[c].air},
               {"air_threshold", plan.settings().values[c].air_threshold}};
    if (const Json* scan = scan_of(plan, c))
      for (const char* const key : {"range", "relevant", "nonfinite"}) entry[key] = scan->at(key);
    j["channels"].push_back(std::move(entry));
  }
  j["cc_samples"] = cc_samples(s);
  j["levels"] = plan.settings().levels;
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
  for (const char* const key : {"spectrum", "motion", "choice", "wavelets", "coding"})
    if (plan.found.contains(key)) j[key] = plan.found[key];
  if (run.turn) j["turn"] = turn_json(*run.turn);
  for (size_t a = 0; a < run.round.size(); ++a)
    if (run.round[a]) j["round"][std::string(1, "xy"[a])] = turn_json(*run.round[a]);
  j["notes"] = s.notes;
  j["warnings"] = s.warnings;
  return j;
}

} // namespace bcc4
