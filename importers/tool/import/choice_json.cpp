// SPDX-License-Identifier: Apache-2.0
#include "tool/import/choice_json.h"

#include <cmath>

#include "tool/json.h"

namespace bcc4 {
namespace {

// "xz": the axes across which planes stand outside.
std::string axes_text(int32_t faces) {
  std::string text;
  for (size_t a = 0; a < 3; ++a)
    if (faces & face_bit(a)) text += "xyz"[a];
  return text;
}

Json shape_json(const LatticeShape& shape, const SeriesDescription& series) {
  return Json{{"lattice", lattice_name(shape.lattice)},
              {"scales", shape.scales},
              {"distances", realised_distances(shape, series.dims)},
              {"density", site_density(shape, series.dims)},
              {"faces_predicted", axes_text(faces_of_part(shape, series.dims))},
              {"ends_predicted", predicts_ends(shape, series.dims)}};
}

Json trial_json(const CodingTrial& t, const SeriesDescription& series) {
  Json j = shape_json(t.coding.shape, series);
  j["steps"] = Json::array();
  for (const StepCoding& c : t.coding.steps) j["steps"].push_back(c.step);
  j["bytes"] = t.bytes;
  j["max_abs"] = t.max_abs, j["psnr"] = t.psnr;
  j["rmse"] = Json::array();
  for (const double m : t.mean_squares) j["rmse"].push_back(std::sqrt(m));
  j["holds"] = t.holds;
  return j;
}

} // namespace

Json spectrum_json(const Spectrum& spectrum) {
  Json j;
  constexpr const char* names[] = {"x", "y", "z", "t"};
  for (size_t a = 0; a < 4; ++a)
    if (spectrum.resolution(a) > 0)
      j["bandwidth"][names[a]] = {{"p50", spectrum.percentile(a, 0.5)},
                                  {"p90", spectrum.percentile(a, 0.9)},
                                  {"p99", spectrum.percentile(a, 0.99)},
                                  {"p999", spectrum.percentile(a, 0.999)},
                                  {"resolution", spectrum.resolution(a)}};
  j["outside_cell"] = spectrum.outside();
  return j;
}

Json choice_json(const LatticeChoice& choice, const SeriesDescription& series) {
  Json j;
  j["sampled_frames"] = choice.sampled_frames;
  j["chosen"] = choice.chosen().name;
  j["labels"] = choice.labels;
  j["half_the_frames"] = choice.half_the_frames;
  j["candidates"] = Json::array();
  for (const LatticeCandidate& c : choice.candidates) {
    Json one = shape_json(c.shape, series);
    if (c.trial) {
      one.update(trial_json(*c.trial, series));
      one["predicted"] = c.predicted;
    }
    one["name"] = c.name;
    if (!c.trial) one["psnr"] = nullptr;
    one["tried"] = c.trial.has_value();
    j["candidates"].push_back(std::move(one));
  }
  j["rounded"] = trial_json(choice.rounded, series);
  return j;
}

Json search_json(const CodingSearch& search, const SeriesDescription& series) {
  Json j{{"sampled_frames", search.sampled_frames}, {"chosen", trial_json(search.chosen(), series)}};
  j["tried"] = Json::array();
  for (const CodingTrial& t : search.tried) j["tried"].push_back(trial_json(t, series));
  return j;
}

Json turn_json(const Turn& turn) {
  return {{"last_to_first", turn.last_to_first},
          {"to_next", turn.to_next},
          {"across", turn.across},
          {"periodic", turn.leads_to_first()}};
}

} // namespace bcc4
