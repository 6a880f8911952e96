// SPDX-License-Identifier: Apache-2.0
// How well samples are predicted by those behind them: what lies beyond an end should be predicted no bolder
// than that.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace bccsplat {

// Noise of predictions (ends.h) that are tried, over the power of the field: waves need little, computed
// tomography and weather much (tests/bench/notes/ends.md).
inline constexpr std::array<double, 5> end_noises{1e-5, 1e-4, 1e-3, 1e-2, 1e-1};
inline constexpr uint8_t usual_noise_level = 2; // where nothing tells

// The squares of what predictions of each noise miss, of rows that end with a known sample.
class NoiseTrial {
 public:
  // n >= 3: samples of a row.
  NoiseTrial(int64_t n, double widening);

  // Samples of a row that are looked at.
  [[nodiscard]] int64_t depth() const { return static_cast<int64_t>(weights_[0].size()) + 1; }
  // A row from its end inwards, `depth` samples.
  void add(std::span<const float> row);
  // A number of end_noises: the boldest of those whose squares are at most `within` times the least.
  [[nodiscard]] uint8_t best(double within = 1) const;

 private:
  std::vector<std::vector<double>> weights_;
  std::array<double, end_noises.size()> squares_{};
};

} // namespace bccsplat
