// SPDX-License-Identifier: Apache-2.0
// Designs the prefilter stages of a kernel: minimises the mean over rho of the error in dB (design by exact
// error, see kernel/wave_error.h) with the response at the sites bounded at every frequency.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "kernel/kernel.h"

namespace bccsplat::bench {

inline constexpr std::array<double, 4> design_rhos{0.3, 0.5, 0.7, 0.9};

// One letter per stage. x: the running coefficients through the cross sum only, the samples through S, T, ST
// (reaches one layer further); f: S, T, ST and X of the coefficients as well (two layers further). The first
// stage has no source terms, for there c = f: its letter is f. For comparison, n: x without ST; a: f without
// the samples.
struct DesignGoal {
  std::string pattern = "fxxx";
  int dimensions = 4;
  std::array<double, 4> weights{0.25, 0.25, 0.25, 0.25}; // of the dB at design_rhos
  double highest = 1.2; // response at the sites, Q * symbol, over all frequencies
  double lowest = 0.1;
  double tap_weight = 0; // dB per mean square of Q over all frequencies: the sum of the squares of the taps
  int starts = 60;
  uint64_t seed = 1;
};

struct Design {
  std::vector<PrefilterStage> stages;
  double objective = 0; // -weighted dB + penalties
};

[[nodiscard]] Design design_prefilter(const Kernel& kernel, const DesignGoal& goal);

// The goal the shipped table of this kernel was made with.
[[nodiscard]] DesignGoal shipped_goal(std::string_view kernel_name, int dimensions);

// How much rounding errors of the stages grow: the worst over all frequencies of the sum over stages of the
// magnitudes added there times what the later stages make of them, relative to the largest response of the
// whole.
[[nodiscard]] double rounding_growth(const std::vector<PrefilterStage>& stages, int dimensions);

} // namespace bccsplat::bench
