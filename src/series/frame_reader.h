// SPDX-License-Identifier: Apache-2.0
// What whoever has a series gives of it: a description, then its frames one by one.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "series/value_type.h"

namespace bccsplat::series {

using Bytes = std::vector<std::byte>;

// Frames first .. end - 1.
struct FrameSpan {
  uint64_t first = 0, end = 0;
};

// A box of samples of one frame.
struct SampleBox {
  std::array<uint64_t, 3> begin{}, dims{};
  [[nodiscard]] uint64_t samples() const { return dims[0] * dims[1] * dims[2]; }
  bool operator==(const SampleBox&) const = default;
};

// A box with its values: sample (i, j, k) of it is at data + i sx + j sy + k sz bytes, in native byte order.
struct Box : SampleBox {
  Type type = Type::f32;
  const std::byte* data = nullptr;
  std::array<uint64_t, 3> stride_bytes{};
};

// Boxes do not overlap; what none covers is air. `storage` keeps their bytes alive.
struct Frame {
  std::vector<Box> boxes;
  std::vector<std::shared_ptr<const Bytes>> storage;
};

struct Channel {
  std::string name = "value";
  std::string unit{};
  Type type = Type::f32;        // of the boxes
  Type precision = Type::f32;   // of the source: a float grid saved as halves holds f16
  double air = 0;               // the value of what no box covers
  bool has_fill = false;        // the source has a "no data" value; the reader turned it into NaN
  std::optional<bool> labels{}; // the source says whether its values are labels
  // Values are offset + step x integers of `precision`; 0: the numbers of the source are the values.
  double step = 0, offset = 0;

  std::vector<uint64_t> active{}; // samples that a sparse source sets, frame by frame; empty: not known

  [[nodiscard]] bool scaled() const { return step != 0; }
};

struct SeriesTimes {
  std::vector<double> values{}; // one per frame, rising strictly
  std::string unit{};           // "" when unknown
  std::string origin{};         // where they came from, for the report
  bool counted = false;         // nobody told them: frames are counted
};

// Where the samples of an axis of space stand, as the source says it.
struct Places {
  std::string unit{};
  bool down = false;                 // coordinates count down
  std::vector<double> coordinates{}; // rising or falling strictly; empty: evenly spaced, as the affine says
};

struct SourceFile {
  std::string path;
  uint64_t bytes = 0;
};

// Affines are row-major 4x4, index space -> world; x is the fastest axis and z the slowest unless the reader
// says otherwise.
struct SeriesDescription {
  std::string format;
  std::array<uint64_t, 4> dims{1, 1, 1, 1};
  std::array<double, 16> affine{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  std::string affine_origin;
  // Along x, y and z. Where some are uneven the affine is of even steps from the first sample to the last.
  std::array<Places, 3> places{};
  std::string spatial_unit;
  std::string axes; // how the axes of the file were read
  SeriesTimes times;
  std::vector<Channel> channels;
  std::vector<SourceFile> files;
  std::vector<int64_t> frame_numbers; // as the user counts them: from file names, or 0, 1, 2 ...
  std::vector<std::string> gaps;      // what was missing and what is in its place
  std::vector<std::string> notes;     // what a careful user wants to know
  std::vector<std::string> warnings;  // what is probably wrong
  std::vector<std::pair<std::string, std::string>> attributes; // free text to keep
  bool sparse = false;
  bool blended = false; // some frames are means of others
};

// Returns whether an axis of space is unevenly spaced.
[[nodiscard]] inline bool has_coordinates(const SeriesDescription& d) {
  for (const Places& p : d.places)
    if (!p.coordinates.empty()) return true;
  return false;
}

// Returns whether a channel has integers of more than 16 bits, which are stored as floats.
[[nodiscard]] inline bool has_wide_integers(const Channel& c) {
  return !c.scaled() && !is_float(c.precision) && type_size(c.precision) > 2;
}

// Returns whether next to nothing of large frames is active, as where parts lie far apart: coarser levels are
// work for all of the box, and pictures have little to draw.
[[nodiscard]] bool is_scattered(const SeriesDescription& series);

// Returns an attribute; "" where there is none.
[[nodiscard]] inline std::string told(const SeriesDescription& d, std::string_view key) {
  for (const auto& [name, value] : d.attributes)
    if (name == key) return value;
  return {};
}

// Frames are cheapest in rising order, all channels of a frame one after the other. Not for concurrent use.
class FrameReader {
 public:
  virtual ~FrameReader() = default;
  [[nodiscard]] virtual const SeriesDescription& description() const = 0;
  [[nodiscard]] virtual Frame read(uint64_t frame, size_t channel) = 0;
  // Returns a frame of which only these samples are wanted: what it has elsewhere may be there or not, and is
  // no air. Readers that can leave bytes unread do.
  [[nodiscard]] virtual Frame read_box(uint64_t frame, size_t channel, const SampleBox& /*wanted*/) {
    return read(frame, channel);
  }
  // Returns whether whole frames fit the memory for reading; else read() refuses them, and read_box() reads
  // no more than it is asked for.
  [[nodiscard]] virtual bool frames_fit() const { return true; }
  // Returns the file that a frame comes from, for error texts.
  [[nodiscard]] virtual std::string frame_name(uint64_t frame) const = 0;
  // May read() be called by another thread than the one that made the reader?
  [[nodiscard]] virtual bool any_thread() const { return true; }
};

// Returns the bytes of one frame of one channel when dense.
[[nodiscard]] inline uint64_t frame_bytes(const SeriesDescription& d, size_t channel) {
  return d.dims[0] * d.dims[1] * d.dims[2] * type_size(d.channels[channel].precision);
}

// Returns the bytes of the values of all frames and channels when dense.
[[nodiscard]] inline uint64_t source_bytes(const SeriesDescription& d) {
  uint64_t bytes = 0;
  for (size_t c = 0; c < d.channels.size(); ++c) bytes += frame_bytes(d, c) * d.dims[3];
  return bytes;
}

// Copies the plane z of a frame as doubles, x fastest: nx * ny values, `air` where no box is.
void gather_plane(const Frame& frame, const std::array<uint64_t, 4>& dims, uint64_t z, double air,
                  double* plane);

} // namespace bccsplat::series
