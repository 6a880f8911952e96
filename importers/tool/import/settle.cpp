#include "tool/import/settle.h"

#include <algorithm>

#include "tool/import/read_series.h"

namespace bcc4 {
namespace {

// Samples for the spectrum: two blocks of its transforms along each axis, one along time; for the proof of a
// time scale not so wide.
constexpr SampleSize kSpectrumSample{64, 32, 1}, kTimeScaleSample{48, 32, 1};

std::vector<ChannelScan> scan_series(FrameReader& reader, const WriterSettings& settings, bool progress) {
  const SeriesDescription& s = reader.description();
  std::vector<ChannelScan> scans(s.channels.size());
  read_series(reader, {0, s.dims[3]}, "scan", progress, [&](uint64_t f, uint32_t c, const Frame& values) {
    scan_frame(values, f, s.dims, air_of(s.channels[c], settings), settings.air_threshold, scans[c]);
  });
  return scans;
}

} // namespace

void settle_import(FrameReader& reader, const Device& device, const Unsettled& unsettled,
                   WriterSettings& settings, ImportPlan& plan) {
  const SeriesDescription& s = reader.description();
  const auto& [bound, auto_time_scale, everything, progress] = unsettled;
  const bool ranged = std::any_of(s.channels.begin(), s.channels.end(),
                                  [&](const Channel& c) { return needs_range(c, settings); });
  if (everything || ranged || bound.any() || auto_time_scale)
    plan.scans = scan_series(reader, settings, progress);

  std::vector<double> air;
  for (const Channel& c : s.channels) air.push_back(air_of(c, settings));
  if (everything || auto_time_scale) plan.spectrum.emplace(sample_series(reader, air, kSpectrumSample), air);
  if (auto_time_scale)
    settings.time_scale = prove_time_scale(device, s, sample_series(reader, air, kTimeScaleSample), settings,
                                           advise_lattice(*plan.spectrum, s.dims[3]).time_scale, plan.scans);

  if (!bound.any()) return;
  plan.search = search_coding(device, s, sample_series(reader, air, {}), settings, bound, plan.scans);
  settings = apply_coding(settings, plan.search->chosen(), bound);
}

} // namespace bcc4
