// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/kernels/kernel_ripple.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/bench/kernels/wave_error.h"

namespace bccsplat::bench {

double mean_taps(const Kernel& kernel, int dimensions) {
  const double ball = 4 * std::numbers::pi / 3 * std::pow(kernel.space.radius, 3);
  return dimensions == 3 ? ball / std::numbers::sqrt2 : ball * 2 * kernel.time.half_width / 2;
}

double dc_ripple_db(const Kernel& kernel, int dimensions) {
  constexpr int n = 24; // positions per axis of an eighth of the cell of a coset
  constexpr double pitch = std::numbers::sqrt2;
  // A B-spline adds no ripple of its own.
  const bool layers = dimensions == 4 && kernel.time.shape == TemporalKernel::Shape::gaussian;
  double worst = 0;
  for (int t = 0; t <= (layers ? n : 0); ++t) {
    std::array<double, 2> by_coset{1, 1};
    if (layers)
      for (const int coset : {0, 1}) {
        double sum = 0;
        for (int k = -4; k <= 4; ++k) sum += kernel.time.value((k + 0.5 * coset - 0.5 * t / n) * pitch);
        by_coset[coset] = sum;
      }
    for (int i = 0; i <= n; ++i)
      for (int j = 0; j <= i; ++j)
        for (int k = 0; k <= j; ++k) {
          double sum = 0;
          for (const int coset : {0, 1})
            for (int a = -3; a <= 4; ++a)
              for (int b = -3; b <= 4; ++b)
                for (int c = -3; c <= 4; ++c) {
                  const double x = (a + 0.5 * coset - 0.5 * i / n) * pitch;
                  const double y = (b + 0.5 * coset - 0.5 * j / n) * pitch;
                  const double z = (c + 0.5 * coset - 0.5 * k / n) * pitch;
                  sum += by_coset[coset] * kernel.space.value(x * x + y * y + z * z);
                }
          worst = std::max(worst, std::abs(sum - 1));
        }
  }
  return 20 * std::log10(worst);
}

double noise_gain(const Kernel& kernel, int dimensions) {
  // Frequencies uniform over one period of the dual lattice; by symmetry the box [0, 1/sqrt2] per axis.
  const KernelSpectrum spectrum(kernel);
  const auto& stages = dimensions == 4 ? kernel.prefilter4 : kernel.prefilter3;
  constexpr size_t corners = 625; // of all_waves: its regular part, not uniform
  const std::vector<WaveSample> waves = all_waves(spectrum, dimensions, corners + 8000);
  double sum = 0;
  for (size_t i = corners; i < waves.size(); ++i) {
    const double q = prefilter_symbol(stages, waves[i].means, dimensions == 4 ? 16 : 8);
    sum += q * q * (waves[i].pass * waves[i].pass + waves[i].alias2);
  }
  return sum / static_cast<double>(waves.size() - corners);
}

} // namespace bccsplat::bench
