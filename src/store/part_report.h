// SPDX-License-Identifier: Apache-2.0
// What each part of a series counted and measured, and how the reports of all parts become that of the
// series.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "fit/fit.h"
#include "store/round_trip.h"

namespace bccsplat {

// What a channel of a part counted and measured.
struct PartChannelReport {
  FitChannelReport fit;
  double bound = 0;                 // of its corrections; 0: none
  std::vector<uint32_t> measured;   // frames, rising
  std::vector<SampleErrors> errors; // of each of these
};
struct PartReport {
  double psnr = 0;     // asked of the series; 0: none
  int32_t lasting = 0; // slabs of the series, see lasting_slabs
  std::vector<PartChannelReport> channels;
};

// Private to one version of the library, as is what refers to it in a part's file.
[[nodiscard]] std::vector<std::byte> write_part_report(const PartReport& report);
// Throws corrupt, truncated, unsupported_version.
[[nodiscard]] PartReport read_part_report(std::span<const std::byte> bytes, size_t channels);
// Where a part stands in its series.
struct PartPlace {
  size_t frame = 0, slab = 0; // the first ones
};
// Adds the report of a part, in the order of order_parts, the first one to an empty one: what is kept by
// frame or slab to that of other blocks of the same ones.
void add_part_report(PartReport& series, PartReport next, const PartPlace& place);

} // namespace bccsplat
