// SPDX-License-Identifier: Apache-2.0
#include "tool/import/part_frames.h"

#include <array>

namespace bcc4 {

FrameSpan wanted_frames(const Writer& writer) {
  FrameSpan frames;
  check(bccsplat_writer_get_part_frames(writer.get(), &frames.first, &frames.end), "");
  return frames;
}

SampleBox wanted_box(const Writer& writer) {
  std::array<uint64_t, 3> end{};
  SampleBox box;
  check(bccsplat_writer_get_part_box(writer.get(), box.begin.data(), end.data()), "");
  for (size_t a = 0; a < 3; ++a) box.dims[a] = end[a] - box.begin[a];
  return box;
}

FrameSpan part_frames(const Device& device, const SeriesDescription& series, const WriterSettings& settings,
                      const FrameSpan& part) {
  auto own = sized<bccsplat_series_part>();
  own.first = part.first, own.end = part.end;
  own.times = series.times.values.data();
  return wanted_frames(create_writer(device, "", series, settings, series.dims[3], &own));
}

SampleBox block_samples(const Device& device, const SeriesDescription& series, const WriterSettings& settings,
                        const SampleBox& block) {
  auto own = sized<bccsplat_series_part>();
  own.end = series.dims[3], own.times = series.times.values.data();
  for (size_t a = 0; a < 3; ++a)
    own.box_begin[a] = block.begin[a], own.box_end[a] = block.begin[a] + block.dims[a];
  return wanted_box(create_writer(device, "", series, settings, series.dims[3], &own));
}

} // namespace bcc4
