// SPDX-License-Identifier: Apache-2.0
// The qualities that a picture may be asked for in.
#pragma once

#include <cstdint>

#include "splat/raise/raise.h"

namespace bccsplat {

enum class Quality : uint8_t { draft = 1, normal = 2, fine = 3, best = 4 };

// What a quality means; the measurements behind it are in tests/bench/notes/render.md.
struct QualitySettings {
  double sheet_step; // T
  int table_entries;
  // Pixels per T: below it gradients are the kernel's own, from there on fourth-order differences.
  double analytic_below;
  // Whether pictures with pixels of 2 T and more are drawn from coarser levels; X-rays always are.
  bool coarse_levels;
  // Steps of this many T and more are drawn with flat_polynomial() in shaded composites; and with
  // short_polynomial() elsewhere, without shading from twice that on.
  double flat_kernel, short_kernel;
  // How sheets are raised where samples are shaded, where they are not, and in isosurfaces.
  RaiseFilter raise, raise_unshaded, raise_surface;
  bool smooth_edges; // of isosurfaces
};
[[nodiscard]] QualitySettings quality_settings(Quality quality);

} // namespace bccsplat
