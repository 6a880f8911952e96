// SPDX-License-Identifier: Apache-2.0
#include "store/write_report.h"

#include <algorithm>
#include <cmath>

#include "fit/frame/unpack.h"

namespace bccsplat {

void WriteReport::add(const FitChannelReport& channel, uint64_t samples, SourceType type) {
  cc_relevant += channel.cc_relevant;
  sites_total += channel.sites_total;
  sites_kept += channel.sites_kept;
  holes += channel.holes;
  clamped += channel.clamped;
  nonfinite += channel.nonfinite;
  coding_max = std::max(coding_max, channel.coding_max);
  cc_samples += samples;
  bytes_source += samples * source_bytes(type);
}

void WriteReport::take_outside(const Lattice4& lattice, int32_t begin, int32_t end, size_t channels) {
  sites_outside = channels * lattice.sites_outside(begin, end);
  sites_total -= sites_outside;
}

void WriteReport::set_file(const Bcc4Report& written) {
  bytes_corrections = written.bytes_corrections;
  bytes = written.bytes;
  slabs_reused += written.slabs_reused;
}

double coding_rmse(std::span<const FitChannelReport> channels) {
  double squares = 0;
  uint64_t sites = 0;
  for (const FitChannelReport& r : channels) {
    squares += r.coding_rmse * r.coding_rmse * static_cast<double>(r.sites_total);
    sites += r.sites_total;
  }
  return sites > 0 ? std::sqrt(squares / static_cast<double>(sites)) : 0;
}

} // namespace bccsplat
