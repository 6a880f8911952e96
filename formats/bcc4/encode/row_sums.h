// SPDX-License-Identifier: Apache-2.0
// Sums over numbers that lie one after the other, in lanes that the compiler keeps side by side: the same on
// every machine, as files depend on them.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

namespace bccsplat {

// The largest magnitude, 0 of none. Bits of magnitudes rise with them.
inline float largest_magnitude(std::span<const float> values) {
  constexpr size_t lanes = 16;
  constexpr uint32_t no_sign = 0x7fffffff;
  const auto bits = [&](size_t i) {
    return std::bit_cast<int32_t>(std::bit_cast<uint32_t>(values[i]) & no_sign);
  };
  std::array<int32_t, lanes> most{};
  size_t i = 0;
  for (; i + lanes <= values.size(); i += lanes)
    for (size_t l = 0; l < lanes; ++l) most[l] = std::max(most[l], bits(i + l));
  for (; i < values.size(); ++i) most[0] = std::max(most[0], bits(i));
  return std::bit_cast<float>(*std::max_element(most.begin(), most.end()));
}

// Whether any is not 0: without a way out, as nearly always all are.
inline bool any_of(std::span<const int32_t> values) {
  int32_t any = 0;
  for (const int32_t v : values) any |= v;
  return any != 0;
}

// Sum of a[i] * b[i], of n numbers.
template<class Sum> Sum sum_products(const float* a, const float* b, size_t n) {
  constexpr size_t lanes = 8;
  std::array<Sum, lanes> sums{};
  size_t i = 0;
  for (; i + lanes <= n; i += lanes)
    for (size_t l = 0; l < lanes; ++l) sums[l] += static_cast<Sum>(a[i + l]) * static_cast<Sum>(b[i + l]);
  for (; i < n; ++i) sums[0] += static_cast<Sum>(a[i]) * static_cast<Sum>(b[i]);
  Sum all{};
  for (const Sum s : sums) all += s;
  return all;
}

} // namespace bccsplat
