// SPDX-License-Identifier: Apache-2.0
// Samples on a grid in the world at some moments: those of a series, or of a .bcc4 file at its source's grid.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "readers/affine.h"
#include "readers/clock.h"
#include "readers/frame_reader.h"
#include "tool/handles.h"

namespace bcc4 {

struct SampledChannel {
  std::string name, unit;
};

class SampledSeries {
 public:
  virtual ~SampledSeries() = default;
  // Hands over the values of a frame, some planes at a time, x fastest; NaN: missing.
  using Take = std::function<void(uint64_t first_plane, std::span<const double> values)>;
  virtual void read(uint64_t frame, uint32_t channel, const Take& take) = 0;

  std::string name;
  std::array<uint64_t, 3> dims{};
  Affine affine{}; // even positions -> world
  // Positions of the samples along x, y and z; empty: their indices.
  std::array<std::vector<double>, 3> even{};
  std::array<std::string, 3> units{}; // along x, y and z of the world
  std::string space;
  Clock clock;
  std::vector<double> times;
  std::vector<SampledChannel> channels;
  // What the files do not tell of themselves: raw values have no place, pages of a TIFF file no origin, and
  // frames that are counted no times.
  bool has_place = true, has_times = true;
};

[[nodiscard]] std::unique_ptr<SampledSeries> series_of_volume(const Volume& volume, const std::string& name);
// `placed`: the user said where samples are.
[[nodiscard]] std::unique_ptr<SampledSeries> series_of_reader(FrameReader& reader, const std::string& name,
                                                              bool placed);

} // namespace bcc4
