// SPDX-License-Identifier: Apache-2.0
// What a writer counted, of all channels together.
#pragma once

#include <cstdint>

#include "fit/fit.h"
#include "formats/bcc4/file_limits.h"
#include "formats/bcc4/write/writer.h"

namespace bccsplat {

struct WriteReport {
  uint64_t frames = 0;
  uint64_t cc_samples = 0;  // of the Cartesian source
  uint64_t cc_relevant = 0; // of these, further than the threshold from air
  uint64_t sites_total = 0; // between the first and the last source sample
  uint64_t sites_outside = 0, sites_kept = 0, holes = 0;
  uint64_t clamped = 0, nonfinite = 0;
  uint64_t bytes_source = 0; // of the source values in the source's precision
  uint64_t slabs_reused = 0; // taken from an earlier file or writer
  uint64_t frames_measured = 0, corrected = 0;
  uint64_t bytes_corrections = 0;
  double coding_max = 0, coding_rmse = 0;
  Bcc4Bytes bytes;

  // Tells apart the sites outside of layers begin .. end - 1, of all channels: those of sites_total so far.
  void take_outside(const Lattice4& lattice, int32_t begin, int32_t end, size_t channels);
  // Adds what a channel of `cc_samples` source samples counted, all but its error of coding.
  void add(const FitChannelReport& channel, uint64_t cc_samples, SourceType type);
  // Sets what is known once the file is finished.
  void set_file(const Bcc4Report& written);
};

// The root mean square error of coding over all sites of several channels.
[[nodiscard]] double coding_rmse(std::span<const FitChannelReport> channels);

} // namespace bccsplat
