// A part of a series that several processes write: what it must be given, what it makes, and how the reports
// of all parts become that of the series.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fit/fit.h"
#include "store/round_trip.h"

namespace bccsplat {

// What is done with the layers of a fit.
struct LayerUse {
  bool coefficients = false;            // of `kernel` are stored, else samples
  std::string kernel;                   // recommended, or of the coefficients
  std::span<const uint32_t> measured{}; // frames, rising, of the whole series
};

// Frames and layers by their numbers in the series.
struct SeriesPart {
  int32_t first_slab = 0, end_slab = 0;   // stored
  int32_t first_layer = 0, end_layer = 0; // stored or measured; by whole slabs but for the last of the series
  FitPart fit;
};
// The part of frames first .. end - 1: slabs whose first layer stands at one of them or between them and
// `end`. options: of the series, dims[3] known.
[[nodiscard]] SeriesPart part_of_series(const Lattice4& lattice, const FitOptions& options,
                                        const LayerUse& use, uint32_t first, uint32_t end);

// Slabs of a series of `frames` frames that stay as they are when more follow; lattice: of either.
[[nodiscard]] int32_t lasting_slabs(const Lattice4& lattice, const FitOptions& options, uint32_t frames);
// What is left to do when a series of which `done` frames are in a file goes on: the slabs behind
// lasting_slabs, from as many frames as they hang on. lattice, options: of the longer series.
[[nodiscard]] FitPart rest_of_series(const Lattice4& lattice, const FitOptions& options, uint32_t done);

// What a writer that continues a whole series will ask for; none: nothing was clamped. lasting: of its slabs.
[[nodiscard]] std::optional<TailInfo> tail_of_series(int32_t lasting,
                                                     std::span<const FitChannelReport> channels);

// What a channel of a part counted and measured.
struct PartChannelReport {
  FitChannelReport fit;
  double bound = 0;                 // of its corrections; 0: none
  std::vector<uint32_t> measured;   // frames
  std::vector<SampleErrors> errors; // theirs
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
// Adds the report of the next frames of the series.
void add_part_report(PartReport& series, PartReport next);

} // namespace bccsplat
