// SPDX-License-Identifier: Apache-2.0
// Coefficients of slabs and their steps: what the encoder settles before it codes.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "tests/bench/coder/context_walk.h"
#include "tests/bench/coder/temporal.h"

namespace bccsplat::bench {

struct Slab {
  int first = 0, frames = 0;
  TimeBasis basis;
  std::vector<float> coefficients;
  std::vector<int32_t> steps;
};

struct StepRule {
  double step = 1, lambda = 0; // squared steps a bit is worth
};

// How many bits a magnitude takes where another is expected.
class BitTable {
 public:
  static constexpr int symbols = 16;
  BitTable();
  void count(int group, int bucket, int magnitude) {
    ++counts_[index(group, bucket)][magnitude < symbols ? magnitude : symbols - 1];
  }
  void settle();
  [[nodiscard]] float bits(int group, int bucket, int magnitude) const {
    constexpr float a_bit_more = 2.0F;
    const auto& row = bits_[index(group, bucket)];
    return magnitude < symbols
               ? row[magnitude]
               : row[symbols - 1] +
                     a_bit_more * static_cast<float>(std::bit_width(uint32_t(magnitude - symbols + 1)) - 1);
  }

 private:
  static size_t index(int group, int bucket) { return static_cast<size_t>(group) * bucket_count + bucket; }
  std::vector<std::array<uint32_t, symbols>> counts_;
  std::vector<std::array<float, symbols>> bits_;
};

class StepPlan {
 public:
  StepPlan(const Chain& chain, int edge, std::vector<Slab>& slabs);
  // A step whose rounding gives about this mean square error.
  [[nodiscard]] double first_step(double mean_square) const;
  void round(double step); // each to the nearest, less where it is small
  void learn_weights();    // of the neighbours, from the steps
  void learn_bits();
  void weigh(const StepRule& rule); // steps anew, bits weighed against errors
  void learn_centres(double step);
  [[nodiscard]] const LevelWeights& weights() const { return weights_; }
  [[nodiscard]] const std::array<uint8_t, 2>& centres() const { return centres_; }

 private:
  template<class Visit> void walk(Visit& visit);
  Chain chain_;
  int edge_;
  std::vector<Slab>& slabs_;
  LevelWeights weights_{};
  BitTable table_;
  std::array<uint8_t, 2> centres_{};
};

inline constexpr int centre_middle = 128; // centres that say: the middle
inline constexpr float centre_unit = 256;

// The value of steps: nearer to zero than the middle of what rounds to them, by centres / 256 of 1, and of
// more.
inline float restored(int32_t steps, float step, const std::array<uint8_t, 2>& centres) {
  if (steps == 0) return 0;
  const int magnitude = steps < 0 ? -steps : steps;
  const float off = static_cast<float>(centres[magnitude > 1 ? 1 : 0] - centre_middle) / centre_unit,
              value = (static_cast<float>(magnitude) + off) * step;
  return steps < 0 ? -value : value;
}

inline constexpr int most_context = 1023; // magnitudes that neighbours tell apart

[[nodiscard]] LevelWeights usual_weights();

} // namespace bccsplat::bench
