// SPDX-License-Identifier: Apache-2.0
#include "readers/stored_values.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "readers/text.h"

namespace bcc4 {
namespace {

// Returns what floats can tell apart where the values of 8 or 16 bits are largest; wider integers are known
// to be rounded.
double float_step(const StoredValues& s) {
  if (is_float(s.type) || type_size(s.type) > 2) return 0;
  return (std::abs(s.slope) * 0x1p16 + std::abs(s.intercept)) * 0x1p-24;
}

} // namespace

void StoredValues::describe(Channel& channel, SeriesDescription& series) const {
  channel.precision = type;
  if (!scaled()) return;
  if (!is_float(type)) channel.step = slope, channel.offset = intercept;
  series.notes.push_back(concat(channel.name, " = ", slope, " x stored + ", intercept));
  if (const double step = float_step(*this); step > std::abs(slope) / 2)
    series.warnings.push_back(concat(channel.name, ": floats near ", short_number(intercept, 8), " are ",
                                     short_number(2 * step, 2), " apart, steps of the source ",
                                     short_number(std::abs(slope), 2), ": some of them are lost"));
}

Type StoredValues::value_type() const {
  if (type == Type::i64 || type == Type::u64) return Type::f64;
  if (!scaled() && fills.empty() && !valid) return type;
  if (is_float(type) && !scaled()) return type == Type::f16 ? Type::f32 : type;
  return type_size(type) < 4 || type == Type::f32 ? Type::f32 : Type::f64;
}

void StoredValues::convert(Bytes& bytes, Type to) const {
  if (to == type && !scaled() && fills.empty() && !valid) return;
  const size_t count = bytes.size() / type_size(type);
  Bytes out(count * type_size(to));
  visit_type(type, [&](auto zero) {
    const auto value = [&](size_t i) {
      const double stored = load_as<decltype(zero)>(bytes.data() + i * sizeof zero);
      if ((std::find(fills.begin(), fills.end(), stored) != fills.end()) ||
          (valid && (stored < (*valid)[0] || stored > (*valid)[1])))
        return std::numeric_limits<double>::quiet_NaN();
      return slope * stored + intercept;
    };
    if (to == Type::f32)
      for (size_t i = 0; i < count; ++i) store_as<float>(value(i), out.data() + i * 4);
    else
      for (size_t i = 0; i < count; ++i) store_as<double>(value(i), out.data() + i * 8);
  });
  bytes.swap(out);
}

} // namespace bcc4
