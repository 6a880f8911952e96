// SPDX-License-Identifier: Apache-2.0
#include "formats/bcc4/encode/bit_costs.h"

#include <algorithm>
#include <cmath>

namespace bccsplat {

BitCosts::BitCosts() : counts_((most_halved + 1) * bucket_count), bits_(counts_.size()) {}

void BitCosts::settle() {
  constexpr double as_if_seen = .5; // once, of a magnitude of 0; half as much of each larger one
  for (size_t i = 0; i < counts_.size(); ++i) {
    std::array<double, symbols> n{};
    double all = 0;
    for (int s = 0; s < symbols; ++s) all += n[s] = counts_[i][s] + std::ldexp(as_if_seen, -std::min(s, 10));
    for (int s = 0; s < symbols; ++s)
      bits_[i][s] = static_cast<float>(-std::log2(n[s] / all)) + (s > 0 ? 1.0F : 0.0F);
    counts_[i] = {};
  }
}

} // namespace bccsplat
