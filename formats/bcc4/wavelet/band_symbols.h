// SPDX-License-Identifier: Apache-2.0
// Steps of a coefficient as bits in their contexts; the same class codes and decodes.
#pragma once

#include <algorithm>
#include <cstdlib>
#include <vector>

#include "formats/bcc4/wavelet/band_walk.h"
#include "formats/bcc4/wavelet/binary_coder.h"
#include "formats/bcc4/wavelet/bit_models.h"
#include "formats/bcc4/wavelet/step_walk.h"

namespace bccsplat {

inline constexpr int most_unary = 14;
inline constexpr int learn_most = most_seen; // bits that a context remembers

template<class Coder> class SymbolCoder {
 public:
  SymbolCoder(Coder& coder, int layers) : coder_(coder), layers_(std::min(layers, most_layers)) {
    zero_.resize(size_t(groups) * bucket_count);
    zero_layer_.resize(size_t(groups) * 8 * most_layers * coarse_buckets);
    zero_near_.resize(size_t(groups) * near_count);
    more_.resize(size_t(most_unary) * bucket_count * 2);
    more_near_.resize(size_t(most_unary) * near_count);
    row_.resize(size_t(groups) * bucket_count);
    expect();
    zero_mixer_.resize(size_t(groups) * bucket_count);
    more_mixer_.resize(size_t(most_unary));
  }
  // Whether a row holds anything, from the sum of what is expected in it.
  bool row(bool any, const WalkRow& row, uint32_t expected) {
    return flag(any, row_[group(row) * bucket_count + bucket_of(expected)]);
  }
  int code(int value, const WalkRow& row, const WalkSite& site) {
    const int g = group(row), bucket = bucket_of(site.sum), near = near_of(site);
    const int layer = std::min(row.k, layers_ - 1);
    const std::array<BitModel*, 3> zero{
        &zero_[g * bucket_count + bucket],
        &zero_layer_[((g * 8 + row.box.direction) * most_layers + layer) * coarse_buckets + bucket / 4],
        &zero_near_[g * near_count + near]};
    if (!code_mixed(coder_, value != 0, zero, zero_mixer_[g * bucket_count + bucket], learn_most)) return 0;
    const bool negative = coder_.code(value < 0, certain / 2);
    const int magnitude = code_magnitude(std::abs(value), row, bucket, near);
    return negative ? -magnitude : magnitude;
  }

 private:
  static constexpr int groups = most_halved + 1, most_layers = 32, coarse_buckets = bucket_count / 4,
                       near_count = 4 * 3 * 3 * 3 * 3;
  static int group(const WalkRow& row) { return group_of(row.box); }
  static int near_of(const WalkSite& s) {
    const auto least = [](int v, int most) { return v < most ? v : most; };
    const int p = s.parent_row ? least(*s.parent_row, 2) : 0;
    return (((least(s.here[-1], 3) * 3 + least(*s.north, 2)) * 3 + least(*s.up, 2)) * 3 +
            least(*s.before, 2)) *
               3 +
           p;
  }
  // Begins with what magnitudes of a known mean are likely to be: s / (1 + s) goes beyond any of them.
  // Means are in tenths of a 1 / weight_unit.
  static BitModel expected(uint64_t mean) {
    constexpr uint16_t as_good_as = 3;
    constexpr uint64_t tenths = 10, least = 64, most = 65000;
    return {static_cast<uint16_t>(std::clamp(certain * mean / (tenths * weight_unit + mean), least, most)),
            as_good_as};
  }
  void expect() {
    constexpr uint64_t least_of_more = 160;
    for (size_t i = 0; i < zero_.size(); ++i) zero_[i] = expected(middle_of(i % bucket_count));
    for (size_t i = 0; i < zero_layer_.size(); ++i)
      zero_layer_[i] = expected(middle_of(i % coarse_buckets * 4 + 2));
    for (size_t i = 0; i < more_.size(); ++i)
      more_[i] = expected(std::max(middle_of(i / 2 % bucket_count), least_of_more));
  }
  static uint64_t middle_of(size_t bucket) {
    constexpr uint64_t tenths = 10, of_small = 3, of_quarter = 45;
    if (bucket < 4) return tenths * bucket + of_small;
    return (of_quarter + tenths * (bucket % 4)) << (bucket / 4 - 1);
  }
  bool flag(bool bit, BitModel& model) {
    constexpr uint32_t least = 16;
    bit = coder_.code(bit, std::clamp<uint32_t>(model.one, least, certain - least));
    model.learn(bit, learn_most);
    return bit;
  }
  int code_magnitude(int magnitude, const WalkRow& row, int bucket, int near) {
    int m = 1;
    for (; m < most_unary; ++m) {
      const std::array<BitModel*, 2> models{
          &more_[(m * bucket_count + bucket) * 2 + (row.box.direction == 0 ? 1 : 0)],
          &more_near_[m * near_count + near]};
      if (!code_mixed(coder_, magnitude > m, models, more_mixer_[m], learn_most)) return m;
    }
    return m + code_rare(coder_, std::max(0, magnitude - m),
                         [&](bool bit, int place) { return flag(bit, length_[place]); });
  }
  Coder& coder_;
  int layers_;
  std::vector<BitModel> zero_, zero_layer_, zero_near_, more_, more_near_, row_;
  std::array<BitModel, most_rare_bits + 1> length_{};
  std::vector<Mixer<3>> zero_mixer_;
  std::vector<Mixer<2>> more_mixer_;
};

} // namespace bccsplat
