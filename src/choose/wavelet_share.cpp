// SPDX-License-Identifier: Apache-2.0
#include "choose/wavelet_share.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "choose/sample.h"
#include "choose/trial.h"

namespace bccsplat::series {
namespace {

constexpr double kShares[] = {.42, .25, .15, .09};

// Boxes of one tile through one slab: an eighth of the series, so that all trials cost less than its import.
SampleSize size_of_trials(const std::array<uint64_t, 4>& dims) {
  constexpr uint64_t tile = 64, slab = 16, part = 8, least = uint64_t{1} << 17, most = uint64_t{1} << 22;
  return {std::clamp(dims[0] * dims[1] * dims[2] * dims[3] / part, least, most), tile, slab};
}

// Returns the bytes of all boxes, each for what it stands for.
double bytes_of(const Device& device, const SeriesDescription& series, const SeriesSample& sample,
                const WriterSettings& settings, const std::vector<ChannelScan>& scans, Watch& watch) {
  double bytes = 0;
  for (const SampleStretch& stretch : sample.stretches) {
    const SeriesDescription part = describe_stretch(series, stretch);
    const Writer writer = create_writer(device, part, settings, scans, stretch.frames);
    auto report = sized<bccsplat_writer_report>();
    if (!write_stretch(writer, part, stretch, watch, &report)) return std::numeric_limits<double>::infinity();
    bytes += stretch.weight *
             static_cast<double>(report.bytes_runs + report.bytes_values + report.bytes_corrections);
  }
  return bytes;
}

// The settings of a store of wavelets with which a stretch of a series is tried.
WriterSettings settings_of_trials(WriterSettings settings) {
  // What is missing is no error of a trial: the import names the place.
  if (settings.nonfinite == BCCSPLAT_NONFINITE_DEFAULT) settings.nonfinite = BCCSPLAT_NONFINITE_HOLE;
  settings.levels = 0, settings.psnr = 0, settings.ends = BCCSPLAT_ENDS_MIRROR, settings.periodic = 0;
  return settings;
}

} // namespace

double choose_wavelet_share(FrameReader& reader, const Device& device, const WriterSettings& settings,
                            const std::vector<ChannelScan>& scans, const std::vector<double>& air,
                            Watch& watch) {
  const SeriesDescription& s = reader.description();
  const SeriesSample sample = sample_series(reader, air, size_of_trials(s.dims), watch);
  WriterSettings tried = settings_of_trials(settings);
  double best = 0, fewest = std::numeric_limits<double>::infinity();
  for (const double share : kShares) {
    tried.wavelet_errors.assign(s.channels.size(), share * settings.abs_error);
    const double bytes = bytes_of(device, s, sample, tried, scans, watch);
    if (bytes > fewest || std::isinf(bytes)) break;
    fewest = bytes, best = share;
  }
  return best;
}

bool takes_less_exactly(FrameReader& reader, const Device& device, const WriterSettings& settings,
                        const std::vector<ChannelScan>& scans, const std::vector<double>& air, Watch& watch) {
  const SeriesDescription& s = reader.description();
  for (size_t c = 0; c < s.channels.size(); ++c)
    if (settings.wavelet_errors[c] >= source_step(s.channels[c])) return false;
  const SeriesSample sample = sample_series(reader, air, size_of_trials(s.dims), watch);
  const WriterSettings wavelets = settings_of_trials(settings);
  WriterSettings exact = wavelets;
  exact.store = BCCSPLAT_STORE_SAMPLES, exact.wavelet_errors.clear(), exact.steps.clear();
  exact.abs_error = 0, exact.abs_errors.clear();
  return bytes_of(device, s, sample, exact, scans, watch) <
         bytes_of(device, s, sample, wavelets, scans, watch);
}

} // namespace bccsplat::series
