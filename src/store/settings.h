// SPDX-License-Identifier: Apache-2.0
// What the writer of a volume is asked for. The options of the C ABI are translated into it once; from here
// on nothing knows of them.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/vec.h"
#include "fit/axis/filter.h"
#include "fit/frame/frame.h"
#include "formats/bcc4/info.h"
#include "lattice/lattice.h"
#include "points/series_block.h"

namespace bccsplat {

// How the field goes on beyond the ends of time.
enum class Ends : uint8_t {
  automatic = 0, // predicted where a series is long enough to pay for the layers
  predict = 1,
  mirror = 2,
  periodic = 3 // the last frame leads to the first
};

// How the field goes on beyond the faces.
enum class Faces : uint8_t {
  automatic =
      0,       // of frames predicted, unless the sites are the source samples; of layers and fields mirrored
  predict = 1, // planes outside are stored; layers and fields that are given hold them
  mirror = 2,
  along = 3 // as predict, across faces_along alone, however few planes there are
};

// Which source frames are compared with what a reader of the file gets.
enum class Measure : uint8_t {
  bounded = 0, // all where an error bound is asked for, else none
  some = 1,    // a few, where that costs nothing the host insists on
  all = 2
};

// What becomes of unfinished work, and of a file that is there already.
enum class Continuity : uint8_t {
  none = 0,    // unfinished work is removed
  journal = 1, // it stays, and so does a journal that tells how far it is whole
  resume = 2,  // as journal, and what an earlier writer left is not coded again
  append = 3   // the series of a finished file goes on
};

struct ChannelSettings {
  std::string name = "value", unit;
  std::optional<SourceType> source_type; // none: that of the first box given to the writer, else f32
  std::optional<ValueType> value_type;   // none: what holds the source
  double air = 0;                        // of the source; the file has the nearest float
  float threshold = 0;
  std::optional<Range> range; // of the values
  double value_step = 0;      // value of one integer code; 0: what spreads the range over the codes
  double wavelet_error = 0;   // root mean square of samples stored as wavelets; 0: what the bounds ask for
  double abs_error = 0;       // bound of the error at source samples; 0: none
  std::optional<bool> labels; // whether values are labels; none: the histogram will say
};

// What one of several processes writes of a series, or what continues a file.
struct PartSettings {
  SeriesBlock block;         // ends of its space that are those of the volume may be to_the_end
  uint64_t early_frames = 0; // given before the first one needed
  std::vector<double> times; // of all frames of the series
};

// Throws invalid_argument unless the times of a series are finite and rise.
void require_rising(std::span<const double> times);

// Layers of a slab of samples. One that is read decodes those before it in its slab.
inline constexpr int32_t slab_layers_of_samples = 8;

// The same of wavelets: the more layers are transformed together the smaller they are, and the more a moment
// decodes; large frames have fewer (tests/bench/notes/coder.md). On D4* a layer has every other site.
[[nodiscard]] inline int32_t slab_layers_of_wavelets(LatticeKind lattice, double sites_of_frame) {
  constexpr double small = 1 << 22, large = 1 << 25;
  const int32_t layers = sites_of_frame <= small ? 16 : sites_of_frame <= large ? 8 : 4;
  return lattice == LatticeKind::d4star ? 2 * layers : layers;
}

struct WriterSettings {
  std::string path; // of the file; empty: a stream
  bool overwrite = false;
  Continuity continuity = Continuity::none;

  std::array<uint32_t, 4> dims{1, 1, 1, 0}; // source samples; dims[3] = 0: as many frames as are given
  LatticeKind lattice = LatticeKind::d4star;
  LatticeScales scales{1, 1, 1, 1};
  bool lowpass = false;
  NonFinite nonfinite = NonFinite::error;
  Ends ends = Ends::automatic;
  Faces faces = Faces::automatic;
  std::array<bool, 3> faces_along{}; // axes of Faces::along
  AxisFlags turning{};               // periodic axes, behind whose last sample comes the first: no faces
  bool wavelets = false;             // samples, in chunks of wavelet coefficients
  bool fixed_predictions = false;    // beyond faces and ends, as of FitOptions
  int levels = 0; // coarser ones, of frames; a series that is appended to keeps those it has
  std::optional<PartSettings> part;

  double psnr = 0; // bound of the error at the source samples of every channel; 0: none
  Measure measure = Measure::bounded;
  uint32_t live_slabs = 0; // after how many slabs the unfinished file is made to be looked at; 0: never

  Affine3 affine; // source index -> world; along uneven axes even positions
  std::array<AxisInfo, 3> axes;
  std::string spatial_unit, time_unit;
  std::string recommended_kernel; // may be empty
  std::vector<ChannelSettings> channels{1};

  [[nodiscard]] bool keeps_journal() const {
    return continuity == Continuity::journal || continuity == Continuity::resume;
  }
  // Returns whether a source sample of some channel may be off by so much and no more.
  [[nodiscard]] bool bounds_samples() const {
    return std::any_of(channels.begin(), channels.end(), [](const auto& c) { return c.abs_error > 0; });
  }
  // Returns whether the source must be compared with the file.
  [[nodiscard]] bool must_measure() const { return bounds_samples() || psnr > 0 || measure == Measure::all; }
};

// Throws invalid_argument or unsupported where options contradict each other. to_stream: there is no file.
void check_settings(const WriterSettings& settings, bool to_stream);

} // namespace bccsplat
