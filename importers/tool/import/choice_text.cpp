// SPDX-License-Identifier: Apache-2.0
// Makes sentences of the JSON that the library tells of a plan, with the options that would change it.
#include "tool/import/choice_text.h"

#include <array>

#include "readers/text.h"

namespace bcc4 {
namespace {

constexpr double kFarOff = 30;        // dB below which the report says what keeps more
constexpr double kSmears = 3;         // voxels a frame
constexpr double kFullTimeAxis = 0.7; // of Nyquist, that holds 99 % of the energy

std::string per_cent(double part) { return concat(short_number(100 * part, 2), " %"); }

// The library's JSON has null for what is exact.
std::string decibels_text(const Json& psnr) {
  return psnr.is_null() ? "exact" : concat(short_number(psnr.get<double>(), 3), " dB");
}

bool is_source_grid(const Json& shape) {
  return shape.at("lattice") == "cc" &&
         shape.at("scales").get<std::array<double, 4>>() == std::array{1., 1., 1., 1.};
}

void add_bandwidth(const Json& spectrum, ReportLines& lines) {
  std::string text;
  const Json bandwidth = spectrum.value("bandwidth", Json::object());
  for (const auto& [axis, part] : bandwidth.items()) {
    text += concat(text.empty() ? "" : ", ", axis);
    for (const char* const key : {"p90", "p99", "p999"})
      text += concat(key == std::string("p90") ? " " : " / ", short_number(part.at(key).get<double>(), 2));
  }
  lines.emplace_back("bandwidth", text + " of Nyquist hold 90 / 99 / 99.9 % of the energy");
  lines.emplace_back("bandwidth", concat(per_cent(spectrum.at("outside_cell").get<double>()),
                                         " of the energy lies outside the cell of the cubic lattice"));
}

// What to say where moments between frames will not be what was between them.
void add_motion(const Json& found, ReportLines& lines) {
  const auto voxels = found.value("motion", 0.0),
             in_time = found.value("/spectrum/bandwidth/t/p99"_json_pointer, 0.0);
  if (voxels < kSmears || in_time < kFullTimeAxis) return;
  lines.emplace_back(
      "motion", concat("things move by about ", short_number(voxels, 2),
                       " voxels from frame to frame: moments between frames will smear; frames so often that "
                       "they move by one or two would not"));
}

void add_choice(const ImportPlan& plan, ReportLines& lines) {
  const auto add = [&](const auto&... parts) { lines.emplace_back("chosen", concat(parts...)); };
  const Json &choice = plan.found.at("choice"), &texts = plan.found.at("texts");
  const size_t best = plan.found.at("best").get<size_t>();
  const Json &candidates = choice.at("candidates"), &chosen = candidates.at(best);
  const auto text_of = [&](size_t i) { return texts.at("candidates").at(i).get<std::string>(); };
  const bool exact = chosen.at("psnr").is_null(), on_grid = is_source_grid(chosen);
  add(text_of(best), ": ", decibels_text(chosen.at("psnr")), " of the sampled range predicted");
  if (!exact && chosen.at("psnr").get<double>() < kFarOff && !on_grid)
    add("far from the source, which has detail as fine as its samples: --lattice cc keeps them all, --psnr "
        "or --abs "
        "the error you say");
  std::string others, labels;
  for (size_t c = 0; c < choice.at("labels").size(); ++c)
    if (choice["labels"][c].get<bool>())
      labels += concat(labels.empty() ? "" : ", ", plan.series.channels[c].name);
  if (!labels.empty())
    add("labels: ", labels, labels.find(',') == std::string::npos ? " has" : " have",
        " no gradations: as precise as the source's",
        on_grid ? ", on its grid; --density blends them" : "; --lattice cc does not blend them");
  if (plan.found.at("takes_less").get<bool>())
    add("as precise as the source's, on its grid: wavelets within 50 dB and 2 % take more");
  bool alike = exact; // a constant: all others keep it, too
  for (size_t i = 0; i < candidates.size(); ++i) {
    if (i == best || !candidates[i].at("tried").get<bool>()) continue;
    alike = alike && candidates[i].at("psnr").is_null();
    others += concat(text_of(i), " ", decibels_text(candidates[i].at("psnr")), "; ");
  }
  if (!choice.at("rounded").at("steps").empty())
    add("lossy: ", texts.at("steps").get<std::string>(), ", which leaves ",
        decibels_text(choice["rounded"].at("psnr")),
        "; --exact keeps the source's precision, --psnr or --abs the error you say");
  if (candidates.size() > 1 && !alike)
    add("instead of ", others, "every second frame, blended ", decibels_text(choice.at("half_the_frames")));
}

// What a store of wavelets promises, and, where nothing was asked for, how to ask.
std::string bound_text(const Json& bound) {
  constexpr double percents = 100;
  const auto psnr = bound.at("psnr").get<double>(), abs = bound.at("abs").get<double>(),
             share = bound.at("share_of_range").get<double>();
  if (share == 0) return abs > 0 ? concat("no sample off by more than ", abs) : concat(psnr, " dB");
  return concat(
      psnr, " dB outside air and no sample off by more than ", short_number(percents * share, 2),
      " % of the range; more or less with --psnr or --abs, half the sites and no bound with --density .5");
}

std::string levels_text(const ImportPlan& plan) {
  const std::string none = plan.found.value("no_levels", "");
  const uint32_t levels = plan.settings().levels;
  if (none == "labels") return "none: labels have no means";
  if (!none.empty())
    return "none: next to nothing of a frame is active (--levels N stores some all the same)";
  if (levels == 0) return "";
  std::string text = "1 coarser one, at 2 times the distance";
  if (levels > 1)
    text = concat(levels, " coarser ones, at 2 to ", uint64_t{1} << levels, " times the distance");
  return text + (plan.auto_levels ? ", for small pictures (--levels none: without)" : "");
}

} // namespace

ReportLines choice_lines(const ImportPlan& plan) {
  const Json& found = plan.found;
  ReportLines lines;
  if (found.contains("constant"))
    lines.emplace_back("bandwidth", "constant");
  else if (found.contains("spectrum"))
    add_bandwidth(found["spectrum"], lines);
  add_motion(found, lines);
  if (found.contains("choice"))
    add_choice(plan, lines);
  else if (found.contains("still"))
    lines.emplace_back(
        "chosen",
        "bcc, as of any single frame: 0.7 of the samples, and lossy at edges; --lattice cc keeps every "
        "sample as it is, --psnr or --abs the error you say");
  if (found.contains("wavelets"))
    lines.emplace_back("chosen", concat("wavelets, ", bound_text(found["wavelets"])));
  if (found.contains("coding"))
    lines.emplace_back("coding",
                       concat(found.at("texts").at("coding").get<std::string>(), " (the smallest of ",
                              found["coding"].at("tried").size(), " tried on ",
                              found["coding"].at("sampled_frames").get<uint64_t>(), " frames)"));
  if (const std::string text = levels_text(plan); !text.empty()) lines.emplace_back("levels", text);
  return lines;
}

} // namespace bcc4
