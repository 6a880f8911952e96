// SPDX-License-Identifier: Apache-2.0
#include "formats/bcc4/wavelet/bit_tables.h"

#include <algorithm>

namespace bccsplat {
namespace {

// 65536 / (1 + exp(-k / 4)), k = 0 .. 36, rounded; between them it is interpolated.
constexpr std::array<int, 37> quarters{32768, 36843, 40793, 44511, 47911, 50941, 53581, 55834, 57724, 59287,
                                       60565, 61598, 62428, 63090, 63615, 64030, 64357, 64614, 64816, 64974,
                                       65097, 65194, 65269, 65328, 65374, 65410, 65438, 65459, 65476, 65489,
                                       65500, 65508, 65514, 65519, 65523, 65526, 65528};
constexpr int quarter = logit_unit / 4;

// The probability of a logit of 0 or more.
constexpr int interpolated(int logit) {
  const int k = logit / quarter, rest = logit % quarter;
  if (rest == 0) return quarters[k];
  return (quarters[k] * (quarter - rest) + quarters[k + 1] * rest + quarter / 2) / quarter;
}

constexpr int probability(int logit) {
  constexpr int least = 6, all = certain;
  const int p = logit < 0 ? all - interpolated(-logit) : interpolated(logit);
  return std::clamp(p, least, all - least);
}

BitTables make_tables() {
  BitTables t{};
  for (int l = -most_logit; l <= most_logit; ++l)
    t.probability[l + most_logit] = static_cast<uint16_t>(probability(l));
  constexpr int width = certain / logit_count;
  int logit = -most_logit;
  for (int i = 0; i < logit_count; ++i) {
    while (logit < most_logit && probability(logit) < i * width + width / 2) ++logit;
    t.logit[i] = static_cast<int16_t>(logit);
  }
  // The first bit counts as much as 1 / 1.6.
  constexpr int tenths = 10, first = 16;
  for (int n = 0; n <= most_seen; ++n)
    t.share[n] = static_cast<uint16_t>((tenths << share_bits) / (tenths * n + first));
  return t;
}

} // namespace

const BitTables bit_tables = make_tables();

} // namespace bccsplat
