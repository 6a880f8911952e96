// SPDX-License-Identifier: Apache-2.0
#include "shade/kind_look.h"

#include <cmath>

namespace bccsplat {
namespace {

// Fog is seen through; a body is seen whole, and what is bright shines through it.
constexpr double thin = 3, puff = 4, body = 8;
constexpr double faint = 2.5, spots = 6; // of both signs
constexpr double few = 0.002, bright = 0.05;

// Greys whose steps look alike: those of a display, in linear light.
std::vector<Vec3> greys(double from, double to) {
  constexpr int steps = 12;
  std::vector<Vec3> colors;
  for (int i = 0; i <= steps; ++i) {
    const double grey = std::pow(from + (to - from) * i / steps, 2.2);
    colors.push_back({grey, grey, grey});
  }
  return colors;
}

const std::vector<Vec3> heat{{0.55, 0.30, 0.26}, {0.85, 0.14, 0.06}, {1, 0.45, 0.02}, {1, 0.9, 0.3}};
const std::vector<Vec3> flame{
    {0.10, 0.01, 0.005}, {0.69, 0.02, 0}, {1, 0.21, 0.002}, {1, 0.69, 0.05}, {1, 1, 0.69}};

} // namespace

const KindLook& kind_look(series::DataKind kind) {
  static const KindLook looks[] = {
      /* unknown */ {{}, thin, faint, few, Layout::volume},
      /* ct */ {greys(0.16, 1), body, faint, bright, Layout::both},
      /* mr */ {greys(0.08, 1), body, faint, bright, Layout::both},
      /* statistic */ {heat, thin, spots, few, Layout::volume},
      /* labels */ {{}, thin, faint, few, Layout::volume},
      /* map */ {{}, thin, faint, few, Layout::flat},
      /* field */ {{}, thin, faint, few, Layout::volume},
      /* smoke */ {greys(0.35, 0.95), puff, faint, few, Layout::volume},
      /* fire */ {flame, thin, faint, few, Layout::volume},
  };
  static_assert(std::size(looks) == std::size(series::data_kind_names));
  return looks[static_cast<size_t>(kind)];
}

} // namespace bccsplat
