// SPDX-License-Identifier: Apache-2.0
// Probabilities and their logits ln(p / (1 - p)), as tables of integers (formats/bcc4.md, section 12).
#pragma once

#include <array>
#include <cstdint>

#include "formats/bcc4/wavelet/binary_coder.h"

namespace bccsplat {

inline constexpr int logit_unit = 256, most_logit = 9 * logit_unit;  // logits are in 1 / logit_unit
inline constexpr int logit_bits = 12, logit_count = 1 << logit_bits; // of a probability that are looked up
inline constexpr int share_bits = 15, most_seen = 255;

struct BitTables {
  std::array<uint16_t, 2 * most_logit + 1> probability; // of the logits -most_logit .. most_logit
  std::array<int16_t, logit_count> logit;               // of the probabilities (i + 1/2) / logit_count
  std::array<uint16_t, most_seen + 1> share;            // that a bit has in a mean, by the bits before it
};
extern const BitTables bit_tables;

[[nodiscard]] inline int probability_of(int logit) { return bit_tables.probability[logit + most_logit]; }
[[nodiscard]] inline int logit_of(uint16_t probability) {
  return bit_tables.logit[probability >> (certain_bits - logit_bits)];
}
[[nodiscard]] inline int learning_share(uint16_t seen) { return bit_tables.share[seen]; }

} // namespace bccsplat
