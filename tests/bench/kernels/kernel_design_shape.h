// SPDX-License-Identifier: Apache-2.0
// Designs the spatial kernels themselves: phi(r) = sum_{j=2..7} a_j u^j of a given radius, monotone.
#pragma once

#include <array>
#include <string_view>

#include "kernel/kernel.h"

namespace bccsplat::bench {

// The figures to beat, in dB with the best prefilter (no bound on its reach): BCC at design_rhos and for a
// constant, D4* at design_rhos.
using ShapeFigures = std::array<double, 9>;

// Of the gradient in space on D4* at design_rhos, with the prefilter that is best for values.
using GradientFigures = std::array<double, 4>;

struct ShapeGoal {
  double radius = 2;
  int time_order = 3;
  ShapeFigures beat{};
  // With `for_gradient` the smallest gain over gradient_beat is maximised instead, while no figure of the
  // values falls below `beat`.
  bool for_gradient = false;
  GradientFigures gradient_beat{};
  double ripple = 0; // a constant may come back off by this at most; 0: by anything
};

struct Shape {
  RadialKernel phi;
  ShapeFigures figures{};
  GradientFigures gradient{};
  double ripple = 0; // largest error of a constant 1
};

// Maximises the smallest gain over the figures to beat (softly), with phi nonnegative and monotone in r.
[[nodiscard]] Shape design_shape(const ShapeGoal& goal);

// The figures of a given shape with the goal's radius and temporal order.
[[nodiscard]] Shape measure_shape(const ShapeGoal& goal, const RadialKernel& phi);

// The goal the shipped kernel was made with; its figures are those of the sets of the first study.
[[nodiscard]] ShapeGoal shipped_shape_goal(std::string_view space_name);

} // namespace bccsplat::bench
