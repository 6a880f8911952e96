// SPDX-License-Identifier: Apache-2.0
#include "choose/finer.h"

#include <cmath>
#include <iterator>

#include "choose/search.h"

namespace bccsplat::series {
namespace {

// Sizes of steps tried where a PSNR was missed: rounding is about half of the error there.
constexpr double kFiner[] = {0.85, 0.6};

// Steps so much finer, or those of the source where it has none in between; wavelets keep theirs where codes
// of 16 bits hold no finer ones.
std::vector<StepCoding> finer_steps(const SeriesDescription& s, const WriterSettings& settings,
                                    const std::vector<ChannelScan>& scans, double factor) {
  std::vector<StepCoding> steps(settings.steps.size());
  for (size_t c = 0; c < steps.size(); ++c) {
    const double unit = source_step(s.channels[c]), finer = factor * settings.steps[c].step;
    const double step = unit == 0 ? finer : std::floor(finer / unit) * unit;
    if (step > unit)
      steps[c] = step_coding(step, scans[c], air_of(s.channels[c], settings), settings.nonfinite);
    if (settings.store == BCCSPLAT_STORE_WAVELETS && steps[c].step == 0) steps[c] = settings.steps[c];
  }
  return steps;
}

} // namespace

void correct_for_psnr(WriterSettings& settings, const std::vector<ChannelScan>& scans) {
  constexpr double kDecibels = 20;
  const double share = kCorrectedPeak * std::pow(10, -settings.psnr / kDecibels);
  settings.abs_error = share * peak_of(scans);
  settings.abs_errors.clear();
  for (const ChannelScan& scan : scans) settings.abs_errors.push_back(share * peak_of({scan}));
}

const char* make_finer(const SeriesDescription& series, const std::vector<ChannelScan>& scans, size_t missed,
                       WriterSettings& settings) {
  if (settings.psnr == 0 || settings.abs_error > 0 || !(peak_of(scans) > 0)) return nullptr;
  if (missed < std::size(kFiner) && !(settings.steps.empty() && settings.wavelet_errors.empty())) {
    settings.steps = finer_steps(series, settings, scans, kFiner[missed]);
    for (double& error : settings.wavelet_errors) error *= kFiner[missed];
    return "finer steps";
  }
  settings.wavelet_errors.clear(); // the library's choice
  correct_for_psnr(settings, scans);
  return "corrections";
}

} // namespace bccsplat::series
