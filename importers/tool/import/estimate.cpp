// SPDX-License-Identifier: Apache-2.0
#include "tool/import/estimate.h"

#include <algorithm>
#include <cmath>

#include "tool/import/report.h"
#include "tool/import/write_series.h"
#include "tool/interrupt.h"
#include "tool/progress.h"

namespace bcc4 {
namespace {

// Sum over the layers of the lattice, per channel.
uint64_t lattice_sites(const Writer& writer) {
  uint64_t sites = 0;
  auto layer = sized<bccsplat_layer_geometry>();
  for (int64_t l = 0, layers = 1; l < layers; ++l) {
    check(bccsplat_writer_get_layer_geometry(writer.get(), l, &layer), "");
    layers = layer.layer_count;
    sites += layer.dims[0] * layer.dims[1] * layer.dims[2];
  }
  return sites;
}

constexpr uint64_t kSampledFrames = 8; // of a series: more take longer, fewer tell less

// Sites of all channels, counted on a writer for the whole series as one part: then the layers are known
// beforehand, whatever becomes of what is not finite.
uint64_t count_sites(const Device& device, const SeriesDescription& s, WriterSettings settings) {
  settings.nonfinite = BCCSPLAT_NONFINITE_DEFAULT;
  settings.faces = BCCSPLAT_FACES_MIRROR; // sites outside are not counted
  auto whole = sized<bccsplat_series_part>();
  whole.end = s.dims[3], whole.times = s.times.values.data();
  const bool as_part = s.dims[3] > 1 && settings.ends != BCCSPLAT_ENDS_PERIODIC; // which has no parts
  return lattice_sites(create_writer(device, "", s, settings, s.dims[3], as_part ? &whole : nullptr)) *
         s.channels.size();
}

// Gives the writer frames first .. first + count - 1; returns the bytes of the largest one.
uint64_t write_frames(FrameReader& reader, const Writer& writer, uint64_t first, uint64_t count) {
  const SeriesDescription& s = reader.description();
  uint64_t largest = 0;
  for (uint64_t f = first; f < first + count; ++f)
    for (uint32_t c = 0; c < s.channels.size(); ++c) {
      stop_if_interrupted();
      const Frame frame = reader.read(f, c);
      uint64_t bytes = 0;
      for (const auto& storage : frame.storage) bytes += storage->size();
      largest = std::max(largest, bytes);
      add_frame(writer, c, s.times.values[f], frame, reader.frame_name(f));
    }
  return largest;
}

} // namespace

ImportEstimate estimate_import(FrameReader& reader, const Device& device, const ImportPlan& plan) {
  const SeriesDescription& s = reader.description();
  const WriterSettings& settings = plan.settings();
  ImportEstimate e;
  e.sites = count_sites(device, s, settings);
  e.sampled_frames = std::min(s.dims[3], kSampledFrames);

  WriterSettings sampled = settings;
  // Too many samples that are not finite are no reason to stop before the plan has been shown.
  if (settings.nonfinite == BCCSPLAT_NONFINITE_DEFAULT) sampled.nonfinite = BCCSPLAT_NONFINITE_HOLE;
  sampled.psnr = 0; // a goal of the series
  if (sampled.abs_error == 0) sampled.measure = BCCSPLAT_MEASURE_SOME;
  // Some frames of a series that goes round do not.
  if (sampled.ends == BCCSPLAT_ENDS_PERIODIC && e.sampled_frames < s.dims[3])
    sampled.ends = BCCSPLAT_ENDS_MIRROR;
  const Writer writer = create_writer(device, "", s, sampled, e.sampled_frames);
  const Progress clock("", 0, false, true);
  // The middle frames: the first ones of a simulation are often empty.
  const uint64_t largest = write_frames(reader, writer, (s.dims[3] - e.sampled_frames) / 2, e.sampled_frames);

  auto report = sized<bccsplat_writer_report>();
  check(bccsplat_writer_finish(writer.get(), &report), "");
  e.errors = measured_errors(writer, s.channels.size(), report.frames_measured).series;
  // The peak of a PSNR is the range of the whole source, not that of the frames that were looked at.
  const Json channels = plan.found.value("channels", Json::array());
  for (size_t c = 0; c < e.errors.size() && c < channels.size(); ++c)
    if (const Json& range = channels[c].at("range"); !range.is_null() && e.errors[c].samples > 0)
      set_peak(e.errors[c], range[1].get<double>() - range[0].get<double>());
  auto info = sized<bccsplat_device_info>();
  check(bccsplat_device_get_info(device.get(), &info), "");
  const double share = static_cast<double>(s.dims[3]) / static_cast<double>(e.sampled_frames);
  e.seconds = clock.seconds() * share;
  e.bytes_file = static_cast<double>(report.bytes_file) * share;
  e.bytes_memory = static_cast<double>(info.memory_peak + 2 * largest); // one frame in use, one read ahead
  return e;
}

} // namespace bcc4
