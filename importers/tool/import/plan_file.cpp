// SPDX-License-Identifier: Apache-2.0
// Writes a plan as JSON: settings by the names of their options, the scan of each channel, names, sizes and
// checksums of the sources. Reads it back, and compares a series with it by all but the checksums.
#include "tool/import/plan_file.h"

#include <algorithm>
#include <filesystem>
#include <limits>

#include "readers/byte_stream.h"
#include "readers/system.h"
#include "tool/import/writer_choices.h"
#include "tool/json.h"
#include "tool/output/output_file.h"

namespace bcc4 {
namespace {

constexpr int kVersion = 3;
constexpr uint64_t kMostBytes = 256 << 20; // of a plan

// Empty: the default.
Json name_of(int32_t value, const Choices<int32_t>& choices) {
  for (const auto& [name, number] : choices)
    if (number == value) return name;
  return nullptr;
}
int32_t value_of(const Json& name, const Choices<int32_t>& choices, int32_t otherwise) {
  if (name.is_null()) return otherwise;
  return option_choice(concat("the plan's"), name.get<std::string>(), choices);
}

// Calls field(key, value) or field(key, value, names of its numbers) for all that a plan says of a channel.
template<class Channel, class Field> void visit_channel(Channel& c, const Field& field) {
  field("set", c.set_mask), field("source_type", c.source_type);
  field("value_type", c.value_type, &kTypeChoices);
  field("air", c.air), field("air_threshold", c.air_threshold);
  field("range", c.range), field("step", c.value_step);
}

// The same of settings, but for their channels.
template<class Settings, class Field> void visit_settings(Settings& s, const Field& field) {
  field("lattice", s.lattice, &kLatticeChoices);
  field("lowpass", s.lowpass);
  field("ends", s.ends, &kEndsChoices), field("faces", s.faces, &kFacesChoices);
  field("periodic", s.periodic_axes, &kPeriodicChoices);
  field("store", s.store, &kStoreChoices);
  field("fixed_predictions", s.fixed_predictions), field("levels", s.levels);
  field("nonfinite", s.nonfinite, &kNonfiniteChoices);
  field("scale", s.scale), field("time_scale", s.time_scale), field("scales", s.scales);
  field("wavelet_errors", s.mean_errors);
  field("abs_error", s.abs_error), field("abs_errors", s.largest_errors), field("psnr", s.psnr);
  field("measure", s.measure, &kMeasureChoices);
  field("kernel", s.kernel);
}

// What writes fields into an object, and what reads them from one; a default has no name and is 0.
auto writes(Json& j) {
  return [&j](const char* key, const auto& value, const Choices<int32_t>* names = nullptr) {
    j[key] = value;
    if (names) j[key] = name_of(j[key].template get<int32_t>(), *names);
  };
}
auto reads(const Json& j) {
  return [&j](const char* key, auto& value, const Choices<int32_t>* names = nullptr) {
    (names ? Json(value_of(j.at(key), *names, 0)) : j.at(key)).get_to(value);
  };
}

Json settings_json(const WriterSettings& s) {
  Json j;
  visit_settings(s, writes(j));
  for (const bccsplat_channel_options& c : s.values) visit_channel(c, writes(j["channels"].emplace_back()));
  return j;
}

WriterSettings read_settings(const Json& j) {
  if (j.contains("filter") && !j.at("filter").is_null() && j.at("filter") != "kaiser8")
    fail_input("it asks for a filter that is no more");
  WriterSettings s;
  visit_settings(s, reads(j));
  for (const Json& c : j.at("channels"))
    visit_channel(s.values.emplace_back(sized<bccsplat_channel_options>()), reads(c));
  return s;
}

PlanFile read_plan(const Json& j) {
  PlanFile plan;
  plan.inputs = j.at("inputs").get<std::vector<std::string>>();
  for (const auto& [key, value] : j.at("options").items()) plan.options.emplace_back(key, value);
  for (const Json& settings : j.at("settings")) plan.attempts.push_back(read_settings(settings));
  plan.dims = j.at("dims").get<std::array<uint64_t, 4>>();
  plan.times = j.at("times").get<std::vector<double>>();
  for (const Json& s : j.at("sources"))
    plan.sources.push_back(
        {s.at("name").get<std::string>(), s.at("bytes").get<uint64_t>(), s.at("crc32").get<uint32_t>()});
  for (const Json& name : j.at("names")) plan.channels.push_back(name.get<std::string>());
  plan.found["channels"] = j.at("channels");
  const size_t channels = plan.channels.size();
  const auto fits = [&](const WriterSettings& s) { return s.values.size() == channels; };
  if (plan.times.size() != plan.dims[3] || channels == 0 || plan.inputs.empty() || plan.attempts.empty() ||
      plan.found["channels"].size() != channels ||
      !std::all_of(plan.attempts.begin(), plan.attempts.end(), fits))
    fail_input("it contradicts itself");
  return plan;
}

std::string absolute(const std::string& path) {
  if (path.starts_with("@")) return "@" + absolute(path.substr(1));
  return to_text(std::filesystem::absolute(to_path(path)));
}

} // namespace

void make_absolute(PlanFile& plan) {
  for (std::string& input : plan.inputs) input = absolute(input);
  std::error_code ignored;
  for (auto& [key, text] : plan.options)
    if (key == "times" && std::filesystem::exists(to_path(text), ignored)) text = absolute(text);
}

void write_plan_file(const std::string& path, const PlanFile& plan, bool overwrite) {
  Json j;
  j["bcc4_plan"] = kVersion;
  j["inputs"] = plan.inputs;
  j["options"] = Json::object();
  for (const auto& [key, text] : plan.options) j["options"][key] = text;
  j["settings"] = Json::array();
  for (const WriterSettings& settings : plan.attempts) j["settings"].push_back(settings_json(settings));
  j["dims"] = plan.dims;
  j["names"] = plan.channels;
  j["channels"] = plan.found.at("channels");
  j["times"] = plan.times;
  j["sources"] = Json::array();
  for (const PlannedSource& s : plan.sources)
    j["sources"].push_back({{"name", s.name}, {"bytes", s.bytes}, {"crc32", s.crc32}});
  const std::string text = j.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
  OutputFile file(path, overwrite);
  file.write(std::as_bytes(std::span(text)));
  file.finish();
}

std::string settings_text(const WriterSettings& settings) { return settings_json(settings).dump(); }

PlanFile read_plan_file(const std::string& path) {
  const std::string text = read_text_file(path, kMostBytes);
  try {
    const Json j = Json::parse(text);
    if (!j.is_object() || j.value("bcc4_plan", 0) != kVersion)
      fail_input(path, ": not a plan of this version; bcc4 import --dry-run --plan ", path, " makes one");
    return read_plan(j);
  } catch (const nlohmann::json::exception& e) {
    fail_input(path, ": not a plan (", e.what(), ")");
  } catch (const Error& e) {
    if (std::string_view(e.what()).starts_with(path)) throw;
    fail_input(path, ": ", e.what());
  }
}

void check_planned(const PlanFile& plan, const std::string& path, const SeriesDescription& s) {
  const auto differs = [&](const auto&... what) {
    fail_input(path, ": the input is not what it was when the plan was made: ", what...,
               "; make the plan anew");
  };
  if (s.dims != plan.dims)
    differs(s.dims[0], " x ", s.dims[1], " x ", s.dims[2], ", ", s.dims[3], " frames instead of ",
            plan.dims[0], " x ", plan.dims[1], " x ", plan.dims[2], ", ", plan.dims[3]);
  std::vector<std::string> names;
  for (const Channel& c : s.channels) names.push_back(c.name);
  if (names != plan.channels) differs("it has ", join(names), " instead of ", join(plan.channels));
  if (s.times.values != plan.times) differs("its times differ");
  if (s.files.size() != plan.sources.size())
    differs(s.files.size(), " files instead of ", plan.sources.size());
  for (size_t i = 0; i < s.files.size(); ++i) {
    const std::string name = to_text(to_path(s.files[i].path).filename());
    if (name != plan.sources[i].name) differs(name, " in the place of ", plan.sources[i].name);
    if (s.files[i].bytes != plan.sources[i].bytes)
      differs(name, " has ", s.files[i].bytes, " bytes instead of ", plan.sources[i].bytes);
  }
}

} // namespace bcc4
