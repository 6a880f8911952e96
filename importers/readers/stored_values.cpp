#include "readers/stored_values.h"

#include <algorithm>
#include <limits>

namespace bcc4 {

Type StoredValues::value_type() const {
  const bool scaled = slope != 1 || intercept != 0;
  if (type == Type::i64 || type == Type::u64) return Type::f64;
  if (!scaled && fills.empty() && !valid) return type;
  if (is_float(type) && !scaled) return type == Type::f16 ? Type::f32 : type;
  return type_size(type) < 4 || type == Type::f32 ? Type::f32 : Type::f64;
}

void StoredValues::convert(Bytes& bytes) const {
  if (value_type() == type && fills.empty() && !valid) return;
  const Type to = value_type();
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
