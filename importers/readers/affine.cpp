// SPDX-License-Identifier: Apache-2.0
#include "readers/affine.h"

#include <algorithm>
#include <cmath>

namespace bcc4 {

Affine affine_from_columns(const std::array<std::array<double, 3>, 3>& columns,
                           const std::array<double, 3>& origin) {
  Affine m{};
  for (size_t row = 0; row < 3; ++row) {
    for (size_t column = 0; column < 3; ++column) m[row * 4 + column] = columns[column][row];
    m[row * 4 + 3] = origin[row];
  }
  m[15] = 1;
  return m;
}

double determinant(const Affine& m) {
  return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) +
         m[2] * (m[4] * m[9] - m[5] * m[8]);
}

bool spans_volume(const Affine& m) {
  constexpr double flat = 1e-9; // of the box with these edges
  if (!std::all_of(m.begin(), m.end(), [](double v) { return std::isfinite(v); })) return false;
  double box = 1;
  for (size_t c = 0; c < 3; ++c) box *= std::hypot(m[c], m[4 + c], m[8 + c]);
  return std::abs(determinant(m)) > flat * box;
}

Affine moved_origin(const Affine& affine, const std::array<double, 3>& begin) {
  Affine m = affine;
  for (size_t row = 0; row < 3; ++row)
    for (size_t column = 0; column < 3; ++column) m[row * 4 + 3] += affine[row * 4 + column] * begin[column];
  return m;
}

} // namespace bcc4
