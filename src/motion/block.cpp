// SPDX-License-Identifier: Apache-2.0
#include "motion/block.h"

#include <algorithm>
#include <array>
#include <cstdlib>

namespace bccsplat::motion {

Block::Block(const Box& from, const Int3& place, int32_t reach) {
  for (size_t a = 0; a < 3; ++a) {
    first_[a] = std::clamp(place[a] - reach, 0, from.dims[a] - 1);
    size_[a] = std::clamp(place[a] + reach, 0, from.dims[a] - 1) - first_[a] + 1;
  }
  const auto hat = [&](size_t a, int32_t i) {
    const int32_t away = std::min(std::abs(first_[a] + i - place[a]), reach);
    return 1 - static_cast<float>(away) / static_cast<float>(reach + 1);
  };
  double sum = 0, squares = 0, all = 0;
  for (int32_t z = 0; z < size_[2]; ++z)
    for (int32_t y = 0; y < size_[1]; ++y)
      for (int32_t x = 0; x < size_[0]; ++x) {
        const float v = from.values[from.index(first_[0] + x, first_[1] + y, first_[2] + z)];
        const float w = hat(0, x) * hat(1, y) * hat(2, z);
        values_.push_back(v), weights_.push_back(w);
        all += w, sum += double{w} * v, squares += double{w} * v * v;
      }
  content_ = static_cast<float>(std::max(squares - sum * sum / all, 0.0));
}

float Block::difference(const Box& to, const Int3& moved, float enough) const {
  std::array<std::array<int32_t, 16>, 3> at; // samples of `to`, along each axis
  for (size_t a = 0; a < 3; ++a)
    for (int32_t i = 0; i < size_[a]; ++i) at[a][i] = std::clamp(first_[a] + i + moved[a], 0, to.dims[a] - 1);
  float sum = 0;
  const float *v = values_.data(), *w = weights_.data();
  for (int32_t z = 0; z < size_[2] && sum <= enough; ++z)
    for (int32_t y = 0; y < size_[1]; ++y) {
      const float* const row = to.values.data() + to.index(0, at[1][y], at[2][z]);
      for (int32_t x = 0; x < size_[0]; ++x, ++v, ++w) {
        const float d = row[at[0][x]] - *v;
        sum += *w * d * d;
      }
    }
  return sum;
}

} // namespace bccsplat::motion
