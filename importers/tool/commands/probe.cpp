// SPDX-License-Identifier: Apache-2.0
// bcc4 probe: values of the field at places, at one moment or over time.
#include <cstdio>
#include <optional>

#include "tool/cli.h"
#include "tool/commands/commands.h"
#include "tool/handles.h"
#include "tool/json.h"
#include "tool/view/dates.h"
#include "tool/view/time_slice.h"

namespace bcc4 {
namespace {

struct ProbeArguments {
  std::string file, channel, kernel;
  std::vector<std::array<double, 3>> places;
  std::optional<double> time;
  bool index = false, json = false;
};

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

Exit run_probe(const ProbeArguments& a) {
  require_option(a.file, "FILE", "bcc4 probe smoke.bcc4 --at 12,30,31");
  if (a.places.empty()) fail_usage("--at X,Y,Z is missing; with --index it counts samples");
  const Device device = create_device(0, 0);
  const Volume volume = open_volume(device, a.file, a.kernel);
  warn_of_part(volume, a.file);
  const uint32_t channel = find_channel(volume, a.channel);
  const std::vector<double> frames = moments_of(volume, a);
  uint64_t missing = 0;
  const std::vector<float> values = values_at(volume, a, channel, frames, missing);
  if (missing > 0)
    std::fprintf(stderr, "bcc4: warning: %llu of %zu values are outside the data or missing in it (nan)%s\n",
                 static_cast<unsigned long long>(missing), values.size(),
                 a.index ? "" : "; --at is a place in the world (bcc4 info: affine), with --index a sample");
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
  return missing == values.size() ? Exit::check_failed : Exit::ok;
}

} // namespace

Run add_probe(Command tool) {
  const auto a = std::make_shared<ProbeArguments>();
  const Command probe = tool.add_command(
      "probe",
      "Print the values of the field at places. Without --time it prints a line for every frame: the "
      "time, and a value for each --at.");
  probe.set_examples({"bcc4 probe smoke.bcc4 --at 28,32,30",
                      "bcc4 probe smoke.bcc4 --at 28,32,30 --time 0.06",
                      "bcc4 probe smoke.bcc4 --at 28,32,30.5 --at 5,5,5 --index --json"});
  probe.add_option("FILE", a->file, "A .bcc4 file");
  probe.add_texts("--at", "X,Y,Z", "A place in the world, in the file's unit; may be given several times",
                  [a](const std::string& text) {
                    const std::vector<double> p = option_numbers("--at", text, 3);
                    a->places.push_back({p[0], p[1], p[2]});
                  });
  add_number(probe, "--time", a->time, "One moment, in the file's unit of time (default: every frame)");
  probe.add_flag("--index", a->index,
                 "Take --at as a sample and --time as a frame number; fractions are allowed");
  probe.add_option("--channel", a->channel, "Channel, by name or number (default: the first)")
      .type_name("NAME");
  probe.add_option("--kernel", a->kernel, "Reconstruction kernel (default: the file's)").type_name("NAME");
  probe.add_flag("--json", a->json, "Report as JSON");
  return [a] { return run_probe(*a); };
}

} // namespace bcc4
