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

constexpr int kVersion = 2;
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

Json settings_json(const WriterSettings& s) {
  Json j;
  j["air"] = s.air ? Json(*s.air) : Json();
  j["air_threshold"] = s.air_threshold;
  j["lattice"] = name_of(s.lattice, kLatticeChoices);
  j["filter"] = name_of(s.filter, kFilterChoices);
  j["lowpass"] = s.lowpass;
  j["ends"] = name_of(s.ends, kEndsChoices);
  j["faces"] = name_of(s.faces, kFacesChoices);
  j["periodic"] = name_of(s.periodic, kPeriodicChoices);
  j["store"] = name_of(s.store, kStoreChoices);
  j["fixed_predictions"] = s.fixed_predictions;
  j["levels"] = s.levels;
  j["nonfinite"] = name_of(s.nonfinite, kNonfiniteChoices);
  j["quantize"] = name_of(s.quantize, kTypeChoices);
  j["scale"] = s.scale, j["time_scale"] = s.time_scale, j["scales"] = s.scales;
  j["steps"] = Json::array();
  for (const StepCoding& c : s.steps) j["steps"].push_back({{"step", c.step}, {"range", c.range}});
  j["wavelet_errors"] = s.wavelet_errors;
  j["abs_error"] = s.abs_error, j["psnr"] = s.psnr;
  j["abs_errors"] = s.abs_errors;
  j["labels"] = s.labels;
  j["measure"] = name_of(s.measure, kMeasureChoices);
  j["kernel"] = s.kernel;
  return j;
}

WriterSettings read_settings(const Json& j) {
  WriterSettings s;
  if (!j.at("air").is_null()) s.air = j.at("air").get<double>();
  s.air_threshold = j.at("air_threshold").get<double>();
  s.lattice = value_of(j.at("lattice"), kLatticeChoices, BCCSPLAT_LATTICE_DEFAULT);
  s.filter = value_of(j.at("filter"), kFilterChoices, BCCSPLAT_FILTER_DEFAULT);
  s.lowpass = j.at("lowpass").get<bool>();
  s.ends = value_of(j.at("ends"), kEndsChoices, BCCSPLAT_ENDS_DEFAULT);
  s.faces = value_of(j.at("faces"), kFacesChoices, BCCSPLAT_FACES_DEFAULT);
  s.periodic = value_of(j.value("periodic", Json()), kPeriodicChoices, 0); // which older plans do not have
  s.store = value_of(j.at("store"), kStoreChoices, BCCSPLAT_STORE_DEFAULT);
  s.fixed_predictions = j.value("fixed_predictions", false); // which older plans do not have
  s.levels = j.value("levels", uint32_t{0});                 // which older plans do not have
  s.nonfinite = value_of(j.at("nonfinite"), kNonfiniteChoices, BCCSPLAT_NONFINITE_DEFAULT);
  s.quantize = value_of(j.at("quantize"), kTypeChoices, BCCSPLAT_TYPE_DEFAULT);
  s.scale = j.at("scale").get<double>(), s.time_scale = j.at("time_scale").get<double>();
  s.scales = j.at("scales").get<std::array<double, 4>>();
  for (const Json& c : j.at("steps"))
    s.steps.push_back({c.at("step").get<double>(), c.at("range").get<std::array<double, 2>>()});
  // Older plans do not have these two.
  s.wavelet_errors = j.value("wavelet_errors", std::vector<double>{});
  s.abs_errors = j.value("abs_errors", std::vector<double>{});
  s.labels = j.value("labels", std::vector<bool>{});
  s.abs_error = j.at("abs_error").get<double>(), s.psnr = j.at("psnr").get<double>();
  s.measure = value_of(j.at("measure"), kMeasureChoices, BCCSPLAT_MEASURE_DEFAULT);
  s.kernel = j.at("kernel").get<std::string>();
  return s;
}

Json scan_json(const ChannelScan& s) {
  Json j;
  j["range"] = s.empty() ? Json() : Json{s.min, s.max};
  j["samples"] = s.samples, j["relevant"] = s.relevant, j["nonfinite"] = s.nonfinite;
  j["missing_frames"] = s.missing;
  return j;
}

ChannelScan read_scan(const Json& j) {
  ChannelScan s;
  if (!j.at("range").is_null())
    s.min = j.at("range").at(0).get<double>(), s.max = j.at("range").at(1).get<double>();
  s.samples = j.at("samples").get<uint64_t>(), s.relevant = j.at("relevant").get<uint64_t>();
  s.nonfinite = j.at("nonfinite").get<uint64_t>();
  s.missing = j.at("missing_frames").get<std::vector<uint64_t>>();
  return s;
}

PlanFile read_plan(const Json& j) {
  PlanFile plan;
  plan.inputs = j.at("inputs").get<std::vector<std::string>>();
  for (const auto& [key, value] : j.at("options").items()) plan.options.emplace_back(key, value);
  plan.settings = read_settings(j.at("settings"));
  plan.dims = j.at("dims").get<std::array<uint64_t, 4>>();
  plan.times = j.at("times").get<std::vector<double>>();
  for (const Json& s : j.at("sources"))
    plan.sources.push_back(
        {s.at("name").get<std::string>(), s.at("bytes").get<uint64_t>(), s.at("crc32").get<uint32_t>()});
  for (const Json& c : j.at("channels")) {
    plan.channels.push_back(c.at("name").get<std::string>());
    plan.scans.push_back(read_scan(c));
  }
  if (plan.times.size() != plan.dims[3] || plan.channels.empty() || plan.inputs.empty())
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
  j["settings"] = settings_json(plan.settings);
  j["dims"] = plan.dims;
  j["channels"] = Json::array();
  for (size_t c = 0; c < plan.channels.size(); ++c) {
    Json entry{{"name", plan.channels[c]}};
    entry.update(scan_json(plan.scans[c]));
    j["channels"].push_back(std::move(entry));
  }
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
