// SPDX-License-Identifier: Apache-2.0
// Fields with known values everywhere, for measuring the fit.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "fit/fit.h"

namespace bccsplat::bench {

// A Cartesian series in memory, x fastest.
struct FitSeries {
  std::array<uint32_t, 4> dims{1, 1, 1, 1};
  std::vector<float> values;
};

// A sum of 4D plane waves whose wave vectors are uniform in the ball |w| <= rho * pi / T.
struct SeriesWaves {
  std::vector<std::array<double, 4>> vector;
  std::vector<double> phase;

  SeriesWaves(double rho, int count, uint32_t seed);
  // Values at the points of a tensor grid given by its coordinates per axis, x fastest.
  [[nodiscard]] std::vector<double> on_grid(const std::array<std::vector<double>, 4>& coordinates) const;
};

// Puffs that drift, turn and swell; 0 where they are thinner than 1e-3, as in data that were cut off. About 3
// % is smoke; values 0 .. about 1.
[[nodiscard]] FitSeries smoke_like(const std::array<uint32_t, 4>& dims);

// Accuracy of the samples on D4*: PSNR in dB (peak: the range of the signal) against the plane waves
// themselves, over the sites that see no mirrored sample.
[[nodiscard]] double sample_psnr(double rho, const std::array<uint32_t, 4>& dims, int waves, uint32_t seed);

} // namespace bccsplat::bench
