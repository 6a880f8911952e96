// SPDX-License-Identifier: Apache-2.0
#include "tool/import/choice_text.h"

#include <cmath>

#include "readers/text.h"

namespace bcc4 {
namespace {

constexpr double kFarOff = 30;        // dB below which the report says what keeps more
constexpr double kSmears = 3;         // voxels a frame
constexpr double kFullTimeAxis = 0.7; // of Nyquist, that holds 99 % of the energy

std::string per_cent(double part) { return concat(short_number(100 * part, 2), " %"); }

} // namespace

std::vector<std::string> choice_lines(const LatticeChoice& choice, const SeriesDescription& series) {
  std::vector<std::string> lines;
  lines.push_back(concat(shape_text(choice.chosen().shape, series.dims), ": ",
                         decibels_text(choice.chosen().trial->psnr), " of the sampled range predicted"));
  if (choice.chosen().trial->psnr < kFarOff && !is_source_grid(choice.chosen().shape))
    lines.push_back("far from the source, which has detail as fine as its samples: --lattice cc keeps "
                    "them all, --psnr or --abs the error you say");
  std::string others, labels;
  bool alike = std::isinf(choice.chosen().trial->psnr); // a constant: all others keep it, too
  for (size_t c = 0; c < choice.labels.size(); ++c)
    if (choice.labels[c]) labels += concat(labels.empty() ? "" : ", ", series.channels[c].name);
  if (!labels.empty())
    lines.push_back(concat("labels: ", labels, labels.find(',') == std::string::npos ? " has" : " have",
                           " no gradations: as precise as the source's",
                           is_source_grid(choice.chosen().shape) ? ", on its grid; --density blends them"
                                                                 : "; --lattice cc does not blend them"));
  if (choice.takes_less)
    lines.push_back("as precise as the source's, on its grid: wavelets within 50 dB and 2 % take more");
  for (size_t i = 0; i < choice.candidates.size(); ++i) {
    const LatticeCandidate& c = choice.candidates[i];
    if (i == choice.best || !c.trial) continue;
    alike = alike && std::isinf(c.trial->psnr);
    others += concat(shape_text(c.shape, series.dims), " ", decibels_text(c.trial->psnr), "; ");
  }
  if (!choice.rounded.coding.steps.empty())
    lines.push_back(concat("lossy: ", steps_text(choice.rounded.coding, series), ", which leaves ",
                           decibels_text(choice.rounded.psnr),
                           "; --exact keeps the source's precision, --psnr or --abs the error you say"));
  if (choice.candidates.size() > 1 && !alike)
    lines.push_back(
        concat("instead of ", others, "every second frame, blended ", decibels_text(choice.half_the_frames)));
  return lines;
}

std::vector<std::string> spectrum_lines(const Spectrum& spectrum) {
  if (spectrum.empty()) return {"constant"};
  std::string text;
  constexpr const char* names[] = {"x", "y", "z", "t"};
  for (size_t a = 0; a < 4; ++a) {
    if (spectrum.resolution(a) == 0) continue;
    text += concat(text.empty() ? "" : ", ", names[a], " ", short_number(spectrum.percentile(a, 0.9), 2),
                   " / ", short_number(spectrum.percentile(a, 0.99), 2), " / ",
                   short_number(spectrum.percentile(a, 0.999), 2));
  }
  return {concat(text, " of Nyquist hold 90 / 99 / 99.9 % of the energy"),
          concat(per_cent(spectrum.outside()), " of the energy lies outside the cell of the cubic lattice")};
}

std::string levels_text(const LevelChoice& choice, uint32_t levels) {
  if (choice.labels) return "none: labels have no means";
  if (choice.scattered)
    return "none: next to nothing of a frame is active (--levels N stores some all the same)";
  if (levels == 0) return "";
  std::string text = "1 coarser one, at 2 times the distance";
  if (levels > 1)
    text = concat(levels, " coarser ones, at 2 to ", uint64_t{1} << levels, " times the distance");
  return text + (choice.automatic ? ", for small pictures (--levels none: without)" : "");
}

std::string motion_text(const std::optional<double>& voxels, const Spectrum& spectrum) {
  if (!voxels || *voxels < kSmears || spectrum.percentile(3, 0.99) < kFullTimeAxis) return "";
  return concat(
      "things move by about ", short_number(*voxels, 2),
      " voxels from frame to frame: moments between frames will smear; frames so often that they move "
      "by one or two would not");
}

} // namespace bcc4
