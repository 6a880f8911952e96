// SPDX-License-Identifier: Apache-2.0
// Probabilities of bits, learnt as they come, in integers: both sides have the same on every machine.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "tests/bench/coder/binary_coder.h"

namespace bccsplat::bench {

// Probability of a set bit in one context: the mean of what was seen, later a running one.
struct BitModel {
  uint16_t one = certain / 2;
  uint16_t seen = 0;
  void learn(bool bit, int most) {
    constexpr int share_bits = 15, most_shares = 256;
    constexpr double first_share = 1.6; // the first bit counts as much as 1 / 1.6
    static constexpr auto share = [] {
      std::array<uint16_t, most_shares> s{};
      for (int n = 0; n < most_shares; ++n)
        s[n] = static_cast<uint16_t>((1 << share_bits) / (n + first_share));
      return s;
    }();
    const int target = bit ? certain - 1 : 0;
    one = static_cast<uint16_t>(one + (((target - one) * share[seen]) >> share_bits));
    if (seen < most) ++seen;
  }
};

// ln(p / (1 - p)) in 1/256 and back.
inline constexpr int logit_unit = 256, most_logit = 9 * logit_unit;
inline constexpr int logit_bits = 12, logit_count = 1 << logit_bits; // of a probability that are looked up
inline const std::array<int16_t, logit_count> logit_of = [] {
  std::array<int16_t, logit_count> t{};
  for (int i = 0; i < logit_count; ++i) {
    const double p = (i + .5) / logit_count;
    t[i] = static_cast<int16_t>(std::lround(std::log(p / (1 - p)) * logit_unit));
  }
  return t;
}();
inline const std::array<uint16_t, 2 * most_logit + 1> probability_of = [] {
  constexpr long least = 6;
  std::array<uint16_t, 2 * most_logit + 1> t{};
  for (int i = 0; i <= 2 * most_logit; ++i) {
    const double p = certain / (1 + std::exp(static_cast<double>(most_logit - i) / logit_unit));
    t[i] = static_cast<uint16_t>(std::clamp(std::lround(p), least, static_cast<long>(certain) - least));
  }
  return t;
}();

inline constexpr int mixer_bits = 14, mixer_unit = 1 << mixer_bits; // a weight of 1

// Several opinions on one bit, weighed by how well they did.
template<size_t n> struct Mixer {
  std::array<int32_t, n> weight;
  Mixer() { weight.fill(mixer_unit * 4 / 3 / static_cast<int>(n)); } // bolder than their mean
};

inline constexpr int most_weight = 1 << 17; // no sum of weighed logits leaves 31 bits
template<size_t n, class Coder>
bool code_mixed(Coder& coder, bool bit, const std::array<BitModel*, n>& models, Mixer<n>& mixer, int most) {
  constexpr int slowly = 18;
  std::array<int, n> logit;
  int sum = 0;
  for (size_t i = 0; i < n; ++i) {
    logit[i] = logit_of[models[i]->one >> (certain_bits - logit_bits)];
    sum += mixer.weight[i] * logit[i];
  }
  const int at = std::clamp(sum >> mixer_bits, -most_logit, most_logit);
  const int one = probability_of[at + most_logit];
  bit = coder.code(bit, one);
  const int error = (bit ? certain - 1 : 0) - one;
  for (size_t i = 0; i < n; ++i) {
    mixer.weight[i] = std::clamp(mixer.weight[i] + ((logit[i] * error + (1 << (slowly - 1))) >> slowly),
                                 -most_weight, most_weight);
    models[i]->learn(bit, most);
  }
  return bit;
}

} // namespace bccsplat::bench
