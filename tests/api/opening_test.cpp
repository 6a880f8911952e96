// SPDX-License-Identifier: Apache-2.0
// What opening a file takes from a stream far away, where each read is a way there and back: the same few
// reads whatever the number of frames, and none for what the file says of itself.
#include <cmath>

#include "host_streams.h"

namespace host {
namespace {

struct FarInfos {
  size_t reads = 0, more = 0; // of opening, and of asking for all infos
  uint64_t corrections = 0, missing = 0;
};

// Opens a file of so many frames, each with corrections and a mask of its own.
[[nodiscard]] FarInfos far_infos(uint32_t frames) {
  NoiseSeries series;
  series.nx = 20, series.ny = 18, series.nz = 17, series.nt = frames, series.scattered = true;
  bccsplat_writer_options o = series.options();
  o.abs_error = 3, o.lattice = BCCSPLAT_LATTICE_CC, o.store = BCCSPLAT_STORE_WAVELETS;
  const Device device = make_device();
  FarFile file(written(device, series, o));
  const bccsplat_read_stream stream = file.stream();
  FarInfos out;
  bccsplat_volume* v = nullptr;
  EXPECT_OK(bccsplat_volume_open_stream(device.get(), &stream, nullptr, &v));
  const Volume volume(v);
  out.reads = file.reads.size();
  auto info = sized<bccsplat_volume_info>();
  EXPECT_OK(bccsplat_volume_get_info(v, &info));
  auto channel = sized<bccsplat_channel_info>();
  EXPECT_OK(bccsplat_volume_get_channel_info(v, 0, &channel));
  out.more = file.reads.size() - out.reads;
  out.corrections = channel.corrections, out.missing = channel.missing;
  return out;
}

[[nodiscard]] uint64_t missing_in(uint32_t frames) {
  NoiseSeries series;
  series.nx = 20, series.ny = 18, series.nz = 17, series.scattered = true;
  uint64_t missing = 0;
  for (uint32_t t = 0; t < frames; ++t)
    for (const float v : series.frame(t)) missing += std::isnan(v);
  return missing;
}

TEST(Opening, TakesThreeReadsOfAnyNumberOfFrames) {
  for (const uint32_t frames : {24u, 96u}) {
    const FarInfos file = far_infos(frames);
    EXPECT_LE(file.reads, 3u) << frames;
    EXPECT_EQ(file.more, 0u) << frames;
    EXPECT_GT(file.corrections, frames);
    EXPECT_EQ(file.missing, missing_in(frames));
  }
}

} // namespace
} // namespace host
