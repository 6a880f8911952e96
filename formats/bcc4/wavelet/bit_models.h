// SPDX-License-Identifier: Apache-2.0
// Probabilities of bits, learnt as they come, in integers: both sides have the same on every machine.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "formats/bcc4/wavelet/binary_coder.h"
#include "formats/bcc4/wavelet/bit_tables.h"

namespace bccsplat {

// Probability of a set bit in one context: the mean of what was seen, later a running one.
struct BitModel {
  uint16_t one = certain / 2;
  uint16_t seen = 0;
  // `most`: as many bits count, at most most_seen.
  void learn(bool bit, int most) {
    const int target = bit ? certain - 1 : 0;
    one = static_cast<uint16_t>(one + (((target - one) * learning_share(seen)) >> share_bits));
    if (seen < most) ++seen;
  }
};

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
    logit[i] = logit_of(models[i]->one);
    sum += mixer.weight[i] * logit[i];
  }
  const int one = probability_of(std::clamp(sum >> mixer_bits, -most_logit, most_logit));
  bit = coder.code(bit, one);
  const int error = (bit ? certain - 1 : 0) - one;
  for (size_t i = 0; i < n; ++i) {
    mixer.weight[i] = std::clamp(mixer.weight[i] + ((logit[i] * error + (1 << (slowly - 1))) >> slowly),
                                 -most_weight, most_weight);
    models[i]->learn(bit, most);
  }
  return bit;
}

} // namespace bccsplat
