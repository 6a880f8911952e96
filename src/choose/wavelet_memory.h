// SPDX-License-Identifier: Apache-2.0
// What an import of wavelets holds at a time.
#pragma once

#include <cstdint>

#include "choose/series_writer.h"
#include "series/frame_reader.h"

namespace bccsplat::series {

// Returns the bytes, about: a slab as codes, as codes that a reader gets, and where these are not the
// source's own numbers as the source has it; frames on their way in; and what tiles are coded with. bound: of
// every sample, 0: none. Where it is a whole number of steps frames wait for the field
// (src/store/round_trip.h).
[[nodiscard]] uint64_t memory_of_wavelets(const SeriesDescription& series, const WriterSettings& settings,
                                          double bound);

} // namespace bccsplat::series
