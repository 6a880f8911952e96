// SPDX-License-Identifier: Apache-2.0
// An orthographic view whose sheets stand perpendicular to the lattice axis nearest to the view direction.
//
// Rays are sheared through the sheets. Samples of all sheets stand on the same lines along the rays, so that
// one affine map takes the pixels of any sheet to its samples.
#pragma once

#include <array>
#include <cstdint>

#include "view/view.h"

namespace bccsplat::bench {

struct StencilView {
  SheetView view;                      // its sheets, seen through the pixels
  std::array<size_t, 3> axes{0, 1, 2}; // of the lattice: u and v in the sheets, w across them
  int phases_v = 2;                    // samples per coset pitch along v; along u there are 2
  // Planes of the lattice, by the axes above: sample (0, 0) of sheet 0, and what a sheet adds.
  Vec3 origin{}, shift{};
  double pitch_v = 1; // planes from sample to sample; along u it is 1
  // Pixel (i, j) lies at sample (u[0] i + u[1] j, v[0] i + v[1] j) of any sheet.
  std::array<double, 2> u{}, v{};
  double density_u = 0, density_v = 0; // samples per T along the lines that the two passes run on

  // What the first pass makes of row v of samples: pixel column i is at sample slope_u() i + row_u() v.
  [[nodiscard]] double slope_u() const { return u[0] - u[1] * v[0] / v[1]; }
  [[nodiscard]] double row_u() const { return u[1] / v[1]; }
};

// sheet_step: lattice units along the rays where these are perpendicular to sheets of the same step of
// make_view().
[[nodiscard]] StencilView make_stencil_view(const Slice& slice, const WorldCamera& camera, int width,
                                            int height, double sheet_step);

} // namespace bccsplat::bench
