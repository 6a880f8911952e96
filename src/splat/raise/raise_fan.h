// SPDX-License-Identifier: Apache-2.0
// Perspective from sheets that are sampled side by side.
//
// The samples of all sheets lie on the same lines along the sheets' normal, as those of an orthographic view,
// and points are drawn as there, with one window at any depth. Only the raising knows of the eye: pixel i of
// sheet k lies at sample scale(k) per (i - foot), and its weights are read from a table.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "splat/raise/raise.h"

namespace bccsplat {

struct RaiseFan {
  struct Axis {
    double per = 0;  // samples per pixel at scale 1
    double foot = 0; // pixel whose ray runs along the sheets' normal
  };
  Axis x, y;
  int taps = 0;       // 0: there is no fan
  double depth = 0;   // of sheet 0, sheet steps from the eye
  double nearest = 0; // scale of the first sheet in front of the eye
  int border = 0;     // pixels around a tile that its gradients look at

  // Weights of a pixel beyond its sample by n / phases, most_taps of them a row.
  static constexpr int phase_bits = 11, phases = 1 << phase_bits;
  std::vector<float> weight;

  [[nodiscard]] double scale(double k) const { return k + depth > nearest ? k + depth : nearest; }
};

// density is in samples per T.
void make_fan_weights(RaiseFan& fan, double density);

// The samples and weights of `count` pixels from `first` on, on a sheet of this scale. What a pixel gets does
// not depend on `first` and `count`.
void fan_axis(const RaiseFan& fan, const RaiseFan::Axis& axis, double scale, int first, int count,
              RaiseAxis& out);

using IntRange = std::array<int, 2>;  // begin, end
using Scales = std::array<double, 2>; // smallest, largest

// Returns at least the samples that pixels [pixel[0], pixel[1]) and their border are raised from on sheets of
// any of the scales.
[[nodiscard]] IntRange fan_samples(const RaiseFan& fan, const RaiseFan::Axis& axis, const Scales& scales,
                                   const IntRange& pixel);
// Returns at least the pixels that samples [sample[0], sample[1]) of such sheets are of use to.
[[nodiscard]] IntRange fan_pixels(const RaiseFan& fan, const RaiseFan::Axis& axis, const Scales& scales,
                                  const IntRange& sample);

} // namespace bccsplat
