// SPDX-License-Identifier: Apache-2.0
// Attributes are brought to the terms of what is stored, sign included: there they are compared.
#include "readers/netcdf/netcdf_values.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "readers/error.h"

namespace bcc4 {
namespace {

// Returns the type of the variable's integers with the sign that _Unsigned gives them.
Type signed_as_told(const NetcdfFile& file, const NetcdfVariable& v) {
  static constexpr std::array<std::array<Type, 2>, 4> pairs{
      {{Type::i8, Type::u8}, {Type::i16, Type::u16}, {Type::i32, Type::u32}, {Type::i64, Type::u64}}};
  const std::string told = lower(trim(file.text(v, "_Unsigned")));
  for (const auto& [with, without] : pairs) {
    if (*v.type == with && told == "true") return without;
    if (*v.type == without && told == "false") return with;
  }
  return *v.type;
}

struct Limits {
  double least, most;
};
Limits limits_of(Type type) {
  return visit_type(type, [](auto zero) -> Limits {
    if constexpr (std::is_integral_v<decltype(zero)>)
      return {static_cast<double>(std::numeric_limits<decltype(zero)>::lowest()),
              static_cast<double>(std::numeric_limits<decltype(zero)>::max())};
    return {-HUGE_VAL, HUGE_VAL};
  });
}

// Returns the same bits as a number of `type`, of a number of the type with the other sign.
double with_sign_of(Type type, double value) {
  if (is_float(type)) return value;
  const auto [least, most] = limits_of(type);
  const double turn = std::ldexp(1.0, static_cast<int>(8 * type_size(type)));
  return value < least ? value + turn : value > most ? value - turn : value;
}

// Are the numbers of an attribute values, and not what is stored for them?
bool told_of_values(const NetcdfFile& file, const NetcdfVariable& v, const StoredValues& s,
                    const char* name) {
  const auto type = file.type_of_numbers(v, name);
  return type && is_float(*type) && !is_float(s.type) && s.scaled();
}

// Returns the integer that stands for a value; where none does so closely, what lies between two.
double packed(const StoredValues& s, double value) {
  const double stored = (value - s.intercept) / s.slope, whole = std::rint(stored);
  return std::abs(stored - whole) <= 1e-3 + 1e-6 * std::abs(whole) ? whole : stored;
}

double as_float(double value) {
  return std::abs(value) <= std::numeric_limits<float>::max() ? static_cast<float>(value) : value;
}

// Returns the numbers of an attribute in the terms of what is stored.
std::vector<double> stored_numbers(const NetcdfFile& file, const NetcdfVariable& v, const StoredValues& s,
                                   const char* name) {
  std::vector<double> numbers = file.numbers(v, name);
  const bool own = file.type_of_numbers(v, name) == v.type, values = told_of_values(file, v, s, name);
  for (double& n : numbers)
    n = values ? packed(s, n) : own ? with_sign_of(s.type, n) : s.type == Type::f32 ? as_float(n) : n;
  return numbers;
}

void set_scale(StoredValues& s, const NetcdfFile& file, const NetcdfVariable& v) {
  s.type = signed_as_told(file, v);
  if (const auto n = file.numbers(v, "scale_factor"); n.size() == 1) s.slope = n[0];
  if (const auto n = file.numbers(v, "add_offset"); n.size() == 1) s.intercept = n[0];
  if (s.slope == 0 || !std::isfinite(s.slope) || !std::isfinite(s.intercept))
    fail_input(file.path(), ": ", v.name, " = ", s.slope, " x stored + ", s.intercept, " says nothing");
}

// A number that no integer of the type stands for is what is stored all the same: there are files that say
// so in floating point.
void add_fills(StoredValues& s, const NetcdfFile& file, const NetcdfVariable& v, const char* name) {
  const std::vector<double> told = file.numbers(v, name), stored = stored_numbers(file, v, s, name);
  const auto [least, most] = limits_of(s.type);
  for (size_t i = 0; i < told.size(); ++i) {
    const bool stands = stored[i] >= least && stored[i] <= most && stored[i] == std::rint(stored[i]);
    const double fill = stands || is_float(s.type) ? stored[i] : told[i];
    if (!std::isnan(fill)) s.fills.push_back(fill);
  }
}

void set_valid(StoredValues& s, const NetcdfFile& file, const NetcdfVariable& v) {
  std::array<double, 2> valid{-HUGE_VAL, HUGE_VAL};
  // Where the scale is negative, the least of the values is the largest that is stored.
  const auto turned = [&](const char* name) { return s.slope < 0 && told_of_values(file, v, s, name); };
  const auto numbers = [&](const char* name) { return stored_numbers(file, v, s, name); };
  if (const auto n = numbers("valid_range"); n.size() == 2) {
    valid = {n[0], n[1]};
    if (turned("valid_range")) std::swap(valid[0], valid[1]);
  }
  if (const auto n = numbers("valid_min"); n.size() == 1) valid[turned("valid_min") ? 1 : 0] = n[0];
  if (const auto n = numbers("valid_max"); n.size() == 1) valid[turned("valid_max") ? 0 : 1] = n[0];
  if (valid[0] > valid[1])
    fail_input(file.path(), ": ", v.name, " has no valid values: its valid range is ", valid[0], " to ",
               valid[1],
               ", as stored; correct valid_range, valid_min and valid_max (ncatted), or delete them");
  if (valid[0] > -HUGE_VAL || valid[1] < HUGE_VAL) s.valid = valid;
}

} // namespace

StoredValues stored_values(const NetcdfFile& file, const NetcdfVariable& v) {
  StoredValues s;
  set_scale(s, file, v);
  for (const char* name : {"_FillValue", "missing_value"}) add_fills(s, file, v, name);
  // Integers have a default fill value as well, but marking it would turn them all into floats.
  if (s.fills.empty() && is_float(s.type))
    if (const auto fill = file.default_fill(v)) s.fills.push_back(*fill);
  set_valid(s, file, v);
  return s;
}

std::vector<double> coordinate_values(const NetcdfFile& file, const NetcdfVariable& v) {
  StoredValues s;
  set_scale(s, file, v);
  add_fills(s, file, v, "_FillValue");
  std::vector<double> values = file.line(v);
  for (double& value : values) {
    const double stored = with_sign_of(s.type, value);
    const bool hole = std::find(s.fills.begin(), s.fills.end(), stored) != s.fills.end();
    value = hole ? std::nan("") : s.slope * stored + s.intercept;
  }
  return values;
}

} // namespace bcc4
