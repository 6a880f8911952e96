// SPDX-License-Identifier: Apache-2.0
// Compares some planes of frames, and of one frame some columns.
#include "tool/import/turn.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "series/frame_planes.h"

namespace bcc4 {
namespace {

constexpr uint64_t kFewestFrames = 6;
constexpr uint64_t kFewestColumns = 16;
constexpr uint64_t kPairsCompared = 6;   // of frames one apart, and half a series apart
constexpr uint64_t kPlanesCompared = 16; // of a frame

// Some planes of the frames of a channel; a frame is read once.
class Planes {
 public:
  Planes(FrameReader& reader, size_t channel, Watch& watch)
      : reader_(reader), watch_(watch), dims_(reader.description().dims), channel_(channel),
        air_(reader.description().channels[channel].air) {}

  // The root mean square of the differences where both have a value; 0 where none has.
  double difference(uint64_t a, uint64_t b) {
    const std::vector<float>&first = planes(a), &second = planes(b);
    double squares = 0, count = 0;
    for (size_t i = 0; i < first.size(); ++i) {
      const double d = static_cast<double>(first[i]) - second[i];
      if (!std::isfinite(d)) continue;
      squares += d * d, ++count;
    }
    return count > 0 ? std::sqrt(squares / count) : 0;
  }

 private:
  const std::vector<float>& planes(uint64_t frame) {
    std::vector<float>& held = held_[frame];
    if (!held.empty()) return held;
    watch_.go_on();
    FramePlanes values(reader_, frame, channel_);
    std::vector<double> plane(dims_[0] * dims_[1]);
    const uint64_t step = std::max<uint64_t>(1, dims_[2] / kPlanesCompared);
    for (uint64_t z = step / 2; z < dims_[2]; z += step) {
      values.gather(z, air_, plane.data());
      held.insert(held.end(), plane.begin(), plane.end());
    }
    return held;
  }

  FrameReader& reader_;
  Watch& watch_;
  std::array<uint64_t, 4> dims_;
  size_t channel_;
  double air_;
  std::map<uint64_t, std::vector<float>> held_;
};

Turn turn_of(Planes planes, uint64_t frames) {
  Turn turn;
  turn.last_to_first = planes.difference(frames - 1, 0);
  const uint64_t half = frames / 2;
  for (uint64_t i = 0; i < kPairsCompared; ++i) {
    const uint64_t next = i * (frames - 2) / (kPairsCompared - 1),
                   far = i * (half - 1) / (kPairsCompared - 1);
    turn.to_next = std::max(turn.to_next, planes.difference(next, next + 1));
    const double across = planes.difference(far, far + half);
    turn.across = i == 0 ? across : std::min(turn.across, across);
  }
  return turn;
}

// Some planes of a frame, whose columns are compared.
class Columns {
 public:
  Columns(FrameReader& reader, size_t channel) : dims_(reader.description().dims) {
    FramePlanes values(reader, dims_[3] / 2, channel);
    const double air = reader.description().channels[channel].air;
    std::vector<double> plane(dims_[0] * dims_[1]);
    const uint64_t step = std::max<uint64_t>(1, dims_[2] / kPlanesCompared);
    for (uint64_t z = step / 2; z < dims_[2]; z += step) {
      values.gather(z, air, plane.data());
      values_.insert(values_.end(), plane.begin(), plane.end());
    }
  }
  // Returns the difference of columns i and j across an axis, as that of frames is computed.
  [[nodiscard]] double difference(size_t axis, uint64_t i, uint64_t j) const {
    double squares = 0, count = 0;
    each(axis, i, [&](size_t at) {
      const double d = values_[at] - values_[at - i * stride(axis) + j * stride(axis)];
      if (std::isfinite(d)) squares += d * d, ++count;
    });
    return count > 0 ? std::sqrt(squares / count) : 0;
  }
  // The standard deviation in a column.
  [[nodiscard]] double varies(size_t axis, uint64_t i) const {
    double sum = 0, squares = 0, count = 0;
    each(axis, i, [&](size_t at) {
      if (std::isfinite(values_[at])) sum += values_[at], squares += values_[at] * values_[at], ++count;
    });
    return count > 0 ? std::sqrt(std::max(0.0, squares / count - sum / count * sum / count)) : 0;
  }
  [[nodiscard]] Turn turn(size_t axis) const {
    Turn turn;
    const uint64_t n = dims_[axis], half = n / 2;
    turn.last_to_first = difference(axis, n - 1, 0), turn.within = varies(axis, 0);
    for (uint64_t i = 0; i < kPairsCompared; ++i) {
      const uint64_t next = i * (n - 2) / (kPairsCompared - 1), far = i * (half - 1) / (kPairsCompared - 1);
      turn.to_next = std::max(turn.to_next, difference(axis, next, next + 1));
      const double across = difference(axis, far, far + half);
      turn.across = i == 0 ? across : std::min(turn.across, across);
    }
    return turn;
  }

 private:
  [[nodiscard]] size_t stride(size_t axis) const { return axis == 0 ? 1 : dims_[0]; }
  // Calls body(place) for the values of a column.
  template<class Body> void each(size_t axis, uint64_t i, const Body& body) const {
    const size_t plane = dims_[0] * dims_[1], other = axis == 0 ? 1 : 0;
    for (size_t z = 0; z < values_.size(); z += plane)
      for (uint64_t j = 0; j < dims_[other]; ++j) body(z + i * stride(axis) + j * stride(other));
  }

  std::array<uint64_t, 4> dims_;
  std::vector<double> values_;
};

} // namespace

std::array<std::optional<Turn>, 2> measure_round(FrameReader& reader, Watch& watch) {
  const SeriesDescription& s = reader.description();
  std::array<std::optional<Turn>, 2> least;
  for (size_t c = 0; c < s.channels.size(); ++c) {
    watch.go_on();
    const Columns columns(reader, c);
    for (size_t a = 0; a < least.size(); ++a)
      if (s.dims[a] >= kFewestColumns && (!least[a] || least[a]->leads_to_first()))
        least[a] = columns.turn(a);
  }
  return least;
}

std::optional<Turn> measure_turn(FrameReader& reader, Watch& watch) {
  const SeriesDescription& s = reader.description();
  if (s.dims[3] < kFewestFrames) return std::nullopt;
  std::optional<Turn> least;
  for (size_t c = 0; c < s.channels.size(); ++c) {
    const Turn turn = turn_of(Planes(reader, c, watch), s.dims[3]);
    if (!least || least->leads_to_first()) least = turn;
  }
  return least;
}

} // namespace bcc4
