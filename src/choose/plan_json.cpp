// SPDX-License-Identifier: Apache-2.0
// Writes down spectrum, lattices, codings and ranges as numbers, and in words what only the choosing can say.
#include "choose/plan_json.h"

#include <array>
#include <cmath>

#include "choose/json.h"

namespace bccsplat::series {
namespace {

// "xz": the axes across which planes stand outside.
std::string axes_text(int32_t faces) {
  std::string text;
  for (size_t a = 0; a < 3; ++a)
    if (faces & face_bit(a)) text += "xyz"[a];
  return text;
}

JsonMembers members_of(const LatticeShape& shape, const SeriesDescription& series) {
  return {{"lattice", json(lattice_name(shape.lattice))},
          {"scales", json_values(shape.scales)},
          {"distances", json_values(realised_distances(shape, series.dims))},
          {"density", json(site_density(shape, series.dims))},
          {"faces_predicted", json(axes_text(faces_of_part(shape, series.dims)))},
          {"ends_predicted", json(predicts_ends(shape, series.dims))}};
}

JsonMembers members_of(const CodingTrial& t, const SeriesDescription& series) {
  JsonMembers j = members_of(t.coding.shape, series);
  std::vector<double> steps, errors;
  for (const StepCoding& c : t.coding.steps) steps.push_back(c.step);
  for (const double m : t.mean_squares) errors.push_back(std::sqrt(m));
  const JsonMembers more{{"steps", json_values(steps)}, {"bytes", json(t.bytes)},
                         {"max_abs", json(t.max_abs)},  {"psnr", json(t.psnr)},
                         {"rmse", json_values(errors)}, {"holds", json(t.holds)}};
  j.insert(j.end(), more.begin(), more.end());
  return j;
}

std::string json_of(const Spectrum& spectrum) {
  JsonMembers j, bandwidth;
  constexpr std::string_view names[] = {"x", "y", "z", "t"};
  for (size_t a = 0; a < 4; ++a)
    if (spectrum.resolution(a) > 0)
      bandwidth.emplace_back(names[a], json_object({{"p50", json(spectrum.percentile(a, 0.5))},
                                                    {"p90", json(spectrum.percentile(a, 0.9))},
                                                    {"p99", json(spectrum.percentile(a, 0.99))},
                                                    {"p999", json(spectrum.percentile(a, 0.999))},
                                                    {"resolution", json(spectrum.resolution(a))}}));
  if (!bandwidth.empty()) j.emplace_back("bandwidth", json_object(bandwidth));
  j.emplace_back("outside_cell", json(spectrum.outside()));
  return json_object(j);
}

std::string json_of(const LatticeCandidate& c, const SeriesDescription& series) {
  JsonMembers j = c.trial ? members_of(*c.trial, series) : members_of(c.shape, series);
  if (c.trial) j.emplace_back("predicted", json(c.predicted));
  j.emplace_back("name", json(c.name));
  if (!c.trial) j.emplace_back("psnr", "null");
  j.emplace_back("tried", json(c.trial.has_value()));
  return json_object(j);
}

std::string json_of(const LatticeChoice& choice, const SeriesDescription& series) {
  std::vector<std::string> candidates;
  for (const LatticeCandidate& c : choice.candidates) candidates.push_back(json_of(c, series));
  return json_object({{"sampled_frames", json(choice.sampled_frames)},
                      {"chosen", json(choice.chosen().name)},
                      {"labels", json_values(choice.labels)},
                      {"half_the_frames", json(choice.half_the_frames)},
                      {"candidates", json_list(candidates)},
                      {"rounded", json_object(members_of(choice.rounded, series))}});
}

std::string json_of(const CodingSearch& search, const SeriesDescription& series) {
  std::vector<std::string> tried;
  for (const CodingTrial& t : search.tried) tried.push_back(json_object(members_of(t, series)));
  return json_object({{"sampled_frames", json(search.sampled_frames)},
                      {"chosen", json_object(members_of(search.chosen(), series))},
                      {"tried", json_list(tried)}});
}

std::string json_of(const ChannelScan& scan) {
  return json_object({{"range", scan.empty() ? "null" : json_values(std::array{scan.min, scan.max})},
                      {"samples", json(scan.samples)},
                      {"relevant", json(scan.relevant)},
                      {"nonfinite", json(scan.nonfinite)},
                      {"beyond", json(scan.beyond)},
                      {"first_frame", json(scan.first_frame)},
                      {"first_voxel", json_values(scan.first_voxel)},
                      {"missing_frames", json_values(scan.missing)}});
}

// The same in the words of a report.
std::string json_of_texts(const ImportPlan& plan) {
  const SeriesDescription& s = plan.series;
  JsonMembers j;
  if (plan.search) j.emplace_back("coding", json(coding_text(plan.search->chosen(), s)));
  if (plan.choice) {
    std::vector<std::string> shapes;
    for (const LatticeCandidate& c : plan.choice->candidates) shapes.push_back(shape_text(c.shape, s.dims));
    j.emplace_back("candidates", json_values(shapes));
    j.emplace_back("steps", json(steps_text(plan.choice->rounded.coding, s)));
  }
  return json_object(j);
}

} // namespace

std::string json_of_plan(const ImportPlan& plan) {
  const SeriesDescription& s = plan.series;
  JsonMembers j;
  if (!plan.scans.empty()) {
    std::vector<std::string> channels;
    for (const ChannelScan& scan : plan.scans) channels.push_back(json_of(scan));
    j.emplace_back("channels", json_list(channels));
  }
  if (!plan.settings.labels.empty()) j.emplace_back("labels", json_values(plan.settings.labels));
  if (plan.spectra) j.emplace_back("spectrum", json_of(plan.spectra->plain));
  if (plan.spectra && plan.spectra->plain.empty()) j.emplace_back("constant", json(true));
  if (plan.motion) j.emplace_back("motion", json(*plan.motion));
  if (plan.choice) {
    j.emplace_back("choice", json_of(*plan.choice, s));
    j.emplace_back("best", json(uint64_t{plan.choice->best}));
    j.emplace_back("takes_less", json(plan.choice->takes_less));
  }
  if (const auto& b = plan.wavelets)
    j.emplace_back(
        "wavelets",
        json_object({{"psnr", json(b->psnr)}, {"abs", json(b->abs)}, {"share_of_range", json(b->share)}}));
  if (plan.search) j.emplace_back("coding", json_of(*plan.search, s));
  if (plan.still) j.emplace_back("still", json(true));
  if (plan.levels.labels || plan.levels.scattered)
    j.emplace_back("no_levels", json(plan.levels.labels ? "labels" : "scattered"));
  j.emplace_back("texts", json_of_texts(plan));
  return json_object(j);
}

} // namespace bccsplat::series
