// SPDX-License-Identifier: Apache-2.0
// What a file of another format is told of the values it gets, and how they come to it: every format that
// export and slice write has a function that makes a VolumeFile.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "readers/affine.h"
#include "readers/value_type.h"

namespace bcc4 {

struct VolumeOutput {
  Type type = Type::f32;
  std::array<uint64_t, 3> dims{}; // x, y, z
  Affine affine{};                // index -> world
  std::string name;               // of the channel
  std::string unit;               // of its values
  std::string space;              // as NRRD calls it; "": not known
  std::string spatial_unit, time_unit;
  std::string epoch, calendar;             // the date of time 0, and the calendar it is in; "": none
  bool series = false;                     // several frames, time slowest
  std::vector<double> times;               // of the frames; none where a slice is not at one time
  std::array<std::string, 3> axis_names{}; // of a slice that is not at one time, such as "y" and "t"
  std::array<std::string, 3> axis_units{}; // along x, y and z of the world, or of that slice
  // What the source says of x, y, z and time, and of the values (readers/records.h).
  std::array<std::string, 4> axis_records{};
  std::string record;
  // Coordinates of the samples along x, y and z; empty: as the affine says.
  std::array<std::vector<double>, 3> coordinates{};
  std::array<bool, 3> coordinates_down{};
  std::optional<double> fill;                            // what stands for missing values; floats have NaN
  std::vector<std::pair<std::string, std::string>> keys; // free text, for formats that have it
};

// Values go in frame by frame, x fastest, in pieces of whole planes that do not cross frames, in native byte
// order. What is not finished leaves no file behind.
class VolumeFile {
 public:
  virtual ~VolumeFile() = default;
  virtual void write(std::span<const std::byte> planes) = 0;
  virtual void finish() = 0;
};

} // namespace bcc4
