// SPDX-License-Identifier: Apache-2.0
// From stored numbers to values: scaling, and what means "no data".
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "readers/frame_reader.h"
#include "readers/value_type.h"

namespace bcc4 {

struct StoredValues {
  Type type = Type::f32;
  double slope = 1, intercept = 0;            // value = slope * stored + intercept; the slope is not 0
  std::vector<double> fills;                  // stored values that mean "no data"
  std::optional<std::array<double, 2>> valid; // stored values outside mean "no data"

  // Returns the type after conversion: the stored one where nothing is to be done, else a float type that
  // holds the values; 64-bit integers become f64.
  [[nodiscard]] Type value_type() const;
  [[nodiscard]] bool scaled() const { return slope != 1 || intercept != 0; }
  // Tells the channel its steps, and the reader's user how its values come about.
  void describe(Channel& channel, SeriesDescription& series) const;
  // Replaces numbers of `type` by values of value_type(), or of another type that holds them, f32 or f64; NaN
  // for no data.
  void convert(Bytes& bytes) const { convert(bytes, value_type()); }
  void convert(Bytes& bytes, Type to) const;
};

} // namespace bcc4
