// SPDX-License-Identifier: Apache-2.0
// What a .bcc4 file says about itself: everything but the samples and their index.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/vec.h"
#include "formats/bcc4/layout.h"
#include "formats/bcc4/part.h"
#include "lattice/lattice.h"
#include "points/correction_source.h"
#include "points/values.h"

namespace bccsplat {

struct Percentile {
  double percent = 0; // in [0, 100]
  double value = 0;
  bool operator==(const Percentile&) const = default;
};

// Corrections at source samples (residuals.h, correction_table.h); they are right for the recommended
// kernel alone.
struct ResidualInfo {
  double step = 0;  // value of one step; 0: no corrections
  double bound = 0; // with them, no finite source sample is wrong by more; 0: nothing is promised
  // Blocks of whole frames, one per source frame, stored == 0 where there is none; empty: none at all.
  std::vector<BlockRef> frames;
  // Version 3 (record 11): the tables of frames, likewise; `frames` then has samples to set only.
  bool local = false;
  CorrectionShape shape = CorrectionShape::tent;
  // The base of the field that they correct (field_base.h); none: air.
  std::optional<float> base;
  std::vector<BlockRef> tables;
  [[nodiscard]] bool any() const { return !frames.empty() || !tables.empty(); }
  bool operator==(const ResidualInfo&) const = default;
};

// How many source samples of a channel, in all of its frames, have a correction, and how many its masks say
// are missing. Without it whoever asks has to read the tables and masks of all frames.
struct FrameSums {
  uint64_t corrections = 0, missing = 0;
  bool operator==(const FrameSums&) const = default;
};

// What was measured at the source samples of a channel while the file was written.
struct MeasuredError {
  enum Kind : uint32_t { lattice, stored, corrected }; // without rounding, as stored, with corrections
  uint32_t channel = 0, level = 0, kind = lattice;
  uint32_t frames = 0;  // that were compared
  uint64_t samples = 0; // likewise
  double rmse = 0, largest = 0, range = 0;
  bool operator==(const MeasuredError&) const = default;
};

struct ChannelInfo : Quantiser {
  std::string name = "value"; // unique in the file, not empty
  std::string quantity;       // what it is, such as "density"; may be empty
  std::string unit;           // of the values; may be empty
  float threshold = 0;        // samples within this of air were dropped
  SourceType source_type = SourceType::unknown;

  // The caller knows these when all of the source has been seen, and sets them before Bcc4Writer::finish.
  Range source_range;                  // of the finite source values
  Range histogram_range;               // of `histogram`; the last bin is closed
  std::vector<uint64_t> histogram;     // 256 bins, or empty
  std::vector<Percentile> percentiles; // rising; may be empty
  std::vector<Range> frames;           // of each source frame, dims[3] of them, or empty
  uint64_t cc_relevant = 0;            // source samples further than `threshold` from air

  // The writer counts these.
  uint64_t sites_kept = 0;
  uint64_t holes = 0;     // kept sites that are missing data
  uint64_t clamped = 0;   // samples outside the range of the stored type
  Range kept_range;       // of the stored samples, absolute; 0..0 when none are kept
  ResidualInfo residuals; // step and bound are the caller's, the frames the writer's
  // The root mean square error that wavelet coefficients may give the stored samples, as it was asked for, in
  // the units of the channel. The caller's.
  double wavelet_error = 0;
  // Samples are what wavelet coefficients on a Cartesian lattice add up to, not the codes nearest to that.
  // The caller's.
  bool linear = false;
  // Which source samples are missing (mask_runs.h), a block for each frame, stored == 0 where none is, frames
  // may share one; empty: none at all.
  std::vector<BlockRef> masks;
  // The writer's: of all channels of a file with corrections or masks; none: an older file does not tell.
  std::optional<FrameSums> sums;

  bool operator==(const ChannelInfo&) const = default;
};

// The times of the source frames.
struct TimeMap {
  bool uniform = true;
  double first = 0, step = 1; // uniform: frame i is at first + i * step
  std::vector<double> times;  // otherwise: dims[3] of them, rising strictly
  std::string unit;           // may be empty
  std::string epoch;          // what time 0 is, such as an ISO 8601 date; may be empty
  [[nodiscard]] double at(uint64_t frame) const {
    return uniform ? first + static_cast<double>(frame) * step : times.at(frame);
  }
  bool operator==(const TimeMap&) const = default;
};

// Where the source samples stand along an axis of space.
struct AxisInfo {
  std::string unit;                // may be empty
  bool down = false;               // coordinates count against the axis of the world, as depths do
  std::vector<double> coordinates; // of its samples, rising or falling strictly; empty: evenly spaced
  bool operator==(const AxisInfo&) const = default;
};

struct SourceInfo {
  std::string name;
  uint64_t bytes = 0;
  uint32_t crc32 = 0; // 0: unknown
  bool operator==(const SourceInfo&) const = default;
};

// What a writer that continues the series cannot see in the file.
struct TailInfo {
  int32_t slabs = 0; // how many of the first ones more frames leave as they are
  std::vector<uint64_t>
      clamped; // per level and channel, samples in them outside the range of the stored type
  bool operator==(const TailInfo&) const = default;
};

// What a writer that continues a series of wavelets cannot see in the file: counts of the samples they were
// made of.
struct CountsInfo {
  int32_t slabs = 0;             // as in TailInfo
  std::vector<std::byte> counts; // of the layers in them; private to one version of the library
  bool operator==(const CountsInfo&) const = default;
};

// A lattice and how its layers are stored. Fixed once samples are written, except dims[3] and last_layer.
struct StoredLattice {
  Lattice4 lattice;
  int32_t slab_layers = 8; // layers per chunk, 1 .. 32
  // Bricks along each axis of a chunk: 1, or of a file of wavelet coefficients one of tile_edges (tile.h).
  int tile_edge = 1;

  [[nodiscard]] int32_t slabs() const { return (lattice.layers() + slab_layers - 1) / slab_layers; }
  [[nodiscard]] int32_t slab_of(int32_t layer) const { return layer / slab_layers; }
  [[nodiscard]] int32_t layers_of(int32_t slab) const { // fewer than slab_layers only in the last slab
    return std::min(slab_layers, lattice.layers() - slab * slab_layers);
  }
  bool operator==(const StoredLattice&) const = default;
};

inline constexpr int most_levels = 15; // beside level 0

// What is said of a channel at a level. The writer counts all but what was clamped before it.
struct LevelChannel {
  uint64_t sites_kept = 0, holes = 0, clamped = 0;
  Range kept_range; // of the stored samples, absolute; 0..0 when none are kept
  bool operator==(const LevelChannel&) const = default;
};

// The same series on a coarser lattice of the same kind.
struct LevelInfo : StoredLattice {
  std::vector<LevelChannel> channels;
  bool operator==(const LevelInfo&) const = default;
};

// A channel at one of the levels of its volume.
struct ChannelLevel {
  ChannelLevel(int c, int l = 0) : channel(c), level(l) {} // a channel alone is meant at level 0
  int channel, level;
  auto operator<=>(const ChannelLevel&) const = default;
};
// Both in one number, as files have it.
inline constexpr uint32_t level_unit = 1u << 24;
[[nodiscard]] inline uint32_t packed(const ChannelLevel& at) { return at.channel + level_unit * at.level; }
[[nodiscard]] inline ChannelLevel unpacked(uint32_t both) {
  return {static_cast<int>(both % level_unit), static_cast<int>(both / level_unit)};
}

struct VolumeInfo : StoredLattice {
  double scale = 1, time_scale = 1; // as asked for when the lattice was fitted, in space their mean
  Affine3 affine;                   // source index -> world; along uneven axes even positions
  std::string spatial_unit;         // empty where an axis is uneven: axes have their own then
  std::array<AxisInfo, 3> axes{};   // all empty where none is uneven
  TimeMap time;
  std::vector<ChannelInfo> channels;
  std::vector<LevelInfo> levels;  // 1 and up, each coarser than the one before
  std::string recommended_kernel; // may be empty
  std::vector<SourceInfo> sources;
  std::vector<std::pair<std::string, std::string>> attributes; // UTF-8, keys unique; order is kept
  std::vector<MeasuredError> errors;                           // rising by channel, level, kind
  std::optional<TailInfo> tail;                                // none: no sample was clamped
  std::optional<PartInfo> part;                                // none: a whole file
  std::optional<CountsInfo> counts; // none: of samples, of layers, or too short to have lasting slabs
  // The series is being written, or was left unfinished; dims[3] of its frames can be looked at.
  bool unfinished = false;
  uint32_t expected_frames = 0; // what its writer was made for; 0: finished, or not known

  [[nodiscard]] uint64_t cc_samples() const { // per channel
    return uint64_t{lattice.dims[0]} * lattice.dims[1] * lattice.dims[2] * lattice.dims[3];
  }
  // Level 0 is the volume's own lattice.
  [[nodiscard]] const StoredLattice& level(int l) const {
    if (l == 0) return *this;
    return levels.at(static_cast<size_t>(l) - 1);
  }
  [[nodiscard]] int level_count() const { return static_cast<int>(levels.size()) + 1; } // with level 0
  [[nodiscard]] bool has_uneven_axes() const {
    return std::any_of(axes.begin(), axes.end(), [](const AxisInfo& a) { return !a.coordinates.empty(); });
  }

  bool operator==(const VolumeInfo&) const = default;
};

} // namespace bccsplat
