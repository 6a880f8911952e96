// SPDX-License-Identifier: Apache-2.0
// bcc4 probe: values of the field at places, and what is along rays, at one moment or over time.
#include <cstdio>
#include <optional>
#include <utility>

#include "readers/byte_stream.h"
#include "readers/text.h"
#include "tool/cli.h"
#include "tool/commands/commands.h"
#include "tool/handles.h"
#include "tool/interrupt.h"
#include "tool/json.h"
#include "tool/output/output_file.h"
#include "tool/probe/ray_table.h"
#include "tool/probe/rays.h"
#include "tool/view/dates.h"
#include "tool/view/time_slice.h"

namespace bcc4 {
namespace {

struct ProbeArguments {
  std::string file, channel, kernel, points, output;
  std::vector<std::array<double, 3>> places;
  std::vector<std::string> names; // of places that a file lists; empty: none has one
  RayArguments rays;
  std::optional<double> time;
  bool index = false, json = false, overwrite = false;
};

// The columns of a list of points: X, Y and Z, and perhaps a name.
struct PointColumns {
  std::array<size_t, 3> place{0, 1, 2};
  std::optional<size_t> name;
};

// Returns which columns the words of a first line name; none: the line holds numbers.
std::optional<PointColumns> columns_of(const std::vector<std::string_view>& words) {
  PointColumns columns;
  size_t found = 0;
  for (size_t n = 0; n < words.size(); ++n) {
    const std::string word = lower(std::string(trim(words[n])));
    if (word == "name" || word == "id" || word == "label") columns.name = n;
    for (size_t a = 0; a < 3; ++a)
      if (word == std::string(1, "xyz"[a])) columns.place[a] = n, ++found;
  }
  return found == 3 ? std::optional(columns) : std::nullopt;
}

// Reads the places of --points: lines of X,Y,Z, or columns by the names of a first line.
void read_points(ProbeArguments& a) {
  constexpr size_t most_bytes = size_t{1} << 28;
  PointColumns columns;
  size_t number = 0;
  const std::string text = read_text_file(a.points, most_bytes);
  for (const std::string_view line : split(text, "\r\n")) {
    const std::vector<std::string_view> words = split_commas(line);
    const auto titles = ++number == 1 ? columns_of(words) : std::nullopt;
    if (trim(line).starts_with('#')) continue;
    if (titles) {
      columns = *titles;
      continue;
    }
    std::array<double, 3> place{};
    for (size_t i = 0; i < 3; ++i) {
      const size_t column = columns.place[i];
      const auto value =
          column < words.size() ? parse_number<double>(trim(words[column])) : std::optional<double>{};
      if (!value)
        fail_input(
            a.points, ": line ", number, ": \"", line,
            "\": X,Y,Z are expected, three numbers with commas "
            "between them, below a first line that names the columns x, y and z where there are others");
      place[i] = *value;
    }
    a.places.push_back(place);
    if (columns.name)
      a.names.emplace_back(*columns.name < words.size() ? trim(words[*columns.name]) : std::string_view{});
  }
  if (a.places.empty()) fail_input(a.points, ": lists no points; lines of X,Y,Z are expected");
}

// The moments that are asked for: one, or all frames.
std::vector<double> moments_of(const Volume& volume, const ProbeArguments& a) {
  const bccsplat_volume_info v = volume_info(volume);
  std::vector<double> frames;
  if (a.time) return {frame_index(volume, *a.time, a.index)};
  for (uint64_t f = 0; f < v.dims[3]; ++f) frames.push_back(static_cast<double>(f));
  return frames;
}

// Values at the places, moment after moment. NaN: outside, or missing data.
std::vector<float> values_at(const Volume& volume, const ProbeArguments& a, uint32_t channel,
                             const std::vector<double>& frames, uint64_t& missing) {
  std::vector<double> points;
  for (const double frame : frames)
    for (const auto& p : a.places) {
      double time = frame;
      if (!a.index) check(bccsplat_volume_index_to_time(volume.get(), frame, &time), "");
      points.insert(points.end(), {p[0], p[1], p[2], time});
    }
  std::vector<float> values(points.size() / 4);
  if (!a.index) {
    check(bccsplat_volume_evaluate_world(volume.get(), channel, values.size(), points.data(), values.data(),
                                         nullptr, &missing),
          "probe");
    return values;
  }
  const bccsplat_status status = bccsplat_volume_evaluate_channel(volume.get(), channel, values.size(),
                                                                  points.data(), values.data(), nullptr);
  if (status != BCCSPLAT_ERROR_OUT_OF_DOMAIN && status != BCCSPLAT_ERROR_HOLE) check(status, "probe");
  for (const float value : values) missing += value != value ? 1 : 0;
  return values;
}

Json moment_json(double time, const std::string& date, std::span<const float> values) {
  Json j;
  j["time"] = time;
  if (!date.empty()) j["date"] = date;
  j["values"] = std::vector<float>(values.begin(), values.end());
  return j;
}

void print_moment(double time, const std::string& date, std::span<const float> values) {
  std::string line = date.empty() ? time_text(time) : date;
  for (const float value : values) line += concat("\t", value);
  std::printf("%s\n", line.c_str());
}

// Writes moments as lines and places as columns, named by their numbers where they have no names.
class SeriesFile {
 public:
  SeriesFile(const ProbeArguments& a, bool dated) : file_(a.output, a.overwrite) {
    std::string line = dated ? "time,date" : "time";
    for (size_t n = 0; n < a.places.size(); ++n)
      line += n < a.names.size() && !a.names[n].empty() ? concat(",", a.names[n]) : concat(",p", n + 1);
    write(line);
  }
  void add(double time, const std::string& date, std::span<const float> values) {
    std::string line = time_text(time);
    if (!date.empty()) line += concat(",", date);
    for (const float value : values) line += concat(",", value);
    write(line);
  }
  void finish() { file_.finish(); }

 private:
  void write(const std::string& line) {
    const std::string whole = line + "\n";
    file_.write(std::as_bytes(std::span(whole)));
  }
  OutputFile file_;
};

// Writes the whole series of all places.
void write_series(const ProbeArguments& a, const Volume& volume, const std::vector<double>& frames,
                  std::span<const float> values) {
  const Dates dates(volume);
  SeriesFile file(a, dates.known());
  for (size_t f = 0; f < frames.size(); ++f) {
    double time = 0;
    check(bccsplat_volume_index_to_time(volume.get(), frames[f], &time), "");
    file.add(time, dates.of(time), values.subspan(f * a.places.size(), a.places.size()));
  }
  file.finish();
}

// Tells how much of what was asked for is not there, and whether anything is.
Exit tell_missing(uint64_t missing, uint64_t all, const char* what, const char* why) {
  if (missing > 0)
    std::fprintf(stderr, "bcc4: warning: %llu of %llu %s (nan)%s\n", static_cast<unsigned long long>(missing),
                 static_cast<unsigned long long>(all), what, why);
  return missing == all ? Exit::check_failed : Exit::ok;
}

// Writes what is along rays, moment by moment.
Exit probe_rays(const ProbeArguments& a, const Volume& volume, uint32_t channel,
                const std::vector<double>& frames) {
  const Rays rays(volume, channel, a.rays, a.index);
  const Dates dates(volume);
  RayTable table(a.output, a.overwrite, dates.known(), a.rays.picks());
  Json list = Json::array();
  uint64_t missing = 0, all = 0;
  for (const double frame : frames) {
    stop_if_interrupted();
    double time = 0;
    check(bccsplat_volume_index_to_time(volume.get(), frame, &time), "");
    const std::vector<RayPlace> places = rays.at(frame);
    for (const RayPlace& p : places) {
      missing += p.value != p.value ? 1 : 0, ++all;
      if (a.json) list.push_back(place_json(time, dates.of(time), p, a.rays.picks()));
    }
    if (!a.json) table.add(time, dates.of(time), places);
  }
  table.finish();
  if (a.json) print_json(list);
  return a.rays.picks()
             ? tell_missing(missing, all, "rays meet nothing of what is looked for", "")
             : tell_missing(
                   missing, all, "values are outside the data or missing in it",
                   a.index
                       ? ""
                       : "; --ray is between places in the world (bcc4 info: affine), with --index samples");
}

void check_arguments(ProbeArguments& a) {
  require_option(a.file, "FILE", "bcc4 probe smoke.bcc4 --at 12,30,31");
  check_rays(a.rays);
  if (!a.points.empty()) read_points(a);
  if (a.places.empty() && a.rays.rays.empty())
    fail_usage("--at X,Y,Z or --points FILE.csv is missing, or a --ray; with --index they count samples");
  if (!a.places.empty() && !a.rays.rays.empty()) fail_usage("--ray excludes --at and --points");
  if (!a.output.empty()) {
    if (a.json) fail_usage("-o writes CSV, --json prints JSON; leave one of them out");
    refuse_existing(a.output, a.overwrite), refuse_source_as_output(a.output, a.file);
  }
}

// What is looked for along rays is where pictures show it: between samples kernel exact ripples.
Volume open_for_probe(const Device& device, const ProbeArguments& a) {
  Volume volume = open_volume(device, a.file, a.kernel);
  const bool ripples = volume_info(volume).recommended_kernel == std::string_view("exact");
  return a.rays.picks() && a.kernel.empty() && ripples ? open_volume(device, a.file, "default")
                                                       : std::move(volume);
}

Exit run_probe(ProbeArguments a) {
  check_arguments(a);
  const Device device = create_device(0, 0);
  const Volume volume = open_for_probe(device, a);
  warn_of_part(volume, a.file);
  const uint32_t channel = find_channel(volume, a.channel);
  const std::vector<double> frames = moments_of(volume, a);
  if (!a.rays.rays.empty()) return probe_rays(a, volume, channel, frames);
  uint64_t missing = 0;
  const std::vector<float> values = values_at(volume, a, channel, frames, missing);
  const Exit found = tell_missing(
      missing, values.size(), "values are outside the data or missing in it",
      a.index ? "" : "; --at is a place in the world (bcc4 info: affine), with --index a sample");
  if (!a.output.empty()) {
    write_series(a, volume, frames, values);
    return found;
  }
  const Dates dates(volume);
  Json list = Json::array();
  for (size_t f = 0; f < frames.size(); ++f) {
    double time = 0;
    check(bccsplat_volume_index_to_time(volume.get(), frames[f], &time), "");
    const auto row = std::span(values).subspan(f * a.places.size(), a.places.size());
    if (a.json)
      list.push_back(moment_json(time, dates.of(time), row));
    else
      print_moment(time, dates.of(time), row);
  }
  if (a.json) print_json(list);
  return found;
}

} // namespace

Run add_probe(const Command& tool) {
  const auto a = std::make_shared<ProbeArguments>();
  const Command probe = tool.add_command(
      "probe",
      "Print the values of the field at places, or what is along rays. Without --time it prints a line for "
      "every frame: the time, and a value for each --at.");
  probe.set_examples({"bcc4 probe smoke.bcc4 --at 28,32,30",
                      "bcc4 probe smoke.bcc4 --at 28,32,30 --time 0.06",
                      "bcc4 probe smoke.bcc4 --at 28,32,30.5 --at 5,5,5 --index --json",
                      "bcc4 probe smoke.bcc4 --points places.csv -o series.csv",
                      "bcc4 probe smoke.bcc4 --ray 0,32,30:63,32,30 --time 0.06 -o along.csv",
                      "bcc4 probe smoke.bcc4 --ray 0,32,30:63,32,30 --first 0.5"});
  probe.add_option("FILE", a->file, "A .bcc4 file");
  probe.add_texts("--at", "X,Y,Z", "A place in the world, in the file's unit; may be given several times",
                  [a](const std::string& text) {
                    const std::vector<double> p = option_numbers("--at", text, 3);
                    a->places.push_back({p[0], p[1], p[2]});
                  });
  probe
      .add_option("--points", a->points,
                  "A CSV file of places: lines of X,Y,Z, or the columns x, y, z and name of a first line")
      .type_name("FILE.csv");
  add_rays(probe, a->rays);
  probe
      .add_option(
          "-o,--output,--out", a->output,
          "Write a CSV file of all moments: a line for each, with the time and a column for each place; of "
          "rays a line for each of their places")
      .type_name("SERIES.csv");
  probe.add_flag("--overwrite", a->overwrite, "Replace an existing output");
  add_number(probe, "--time", a->time, "One moment, in the file's unit of time (default: every frame)");
  probe.add_flag(
      "--index", a->index,
      "Take --at and the ends of --ray as samples and --time as a frame number; fractions are allowed");
  probe.add_option("--channel", a->channel, "Channel, by name or number (default: the first)")
      .type_name("NAME");
  probe
      .add_option("--kernel", a->kernel,
                  "Reconstruction kernel (default: the file's; for what is looked for along rays of a file "
                  "with kernel "
                  "exact the smoother default)")
      .type_name("NAME");
  probe.add_flag("--json", a->json, "Report as JSON");
  return [a] { return run_probe(*a); };
}

} // namespace bcc4
