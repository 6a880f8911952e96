// Designs the spatial kernels themselves: phi(r) = sum_{j=2..7} a_j u^j of a given radius, monotone.
#pragma once

#include <array>
#include <string_view>

#include "kernel/kernel.h"

namespace bccsplat::bench {

// The figures to beat, in dB with the best prefilter (no bound on its reach): BCC at design_rhos and for a
// constant, D4* at design_rhos.
using ShapeFigures = std::array<double, 9>;

struct ShapeGoal {
  double radius = 2;
  int time_order = 3;
  ShapeFigures beat{};
};

struct Shape {
  RadialKernel phi;
  ShapeFigures figures{};
};

// Maximises the smallest gain over the figures to beat (softly), with phi nonnegative and monotone in r.
[[nodiscard]] Shape design_shape(const ShapeGoal& goal);

// The goal the shipped kernel was made with; its figures are those of the sets of the first study.
[[nodiscard]] ShapeGoal shipped_shape_goal(std::string_view space_name);

} // namespace bccsplat::bench
