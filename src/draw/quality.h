// SPDX-License-Identifier: Apache-2.0
// The qualities that a picture may be asked for in.
#pragma once

#include <cstdint>

namespace bccsplat {

enum class Quality : uint8_t { draft = 1, normal = 2, fine = 3, best = 4 };

// What a quality means to every drawer; the measurements behind it are in tests/bench/notes/render.md. What
// it means to sheets alone is in splat/sheet_settings.h.
struct QualitySettings {
  double sheet_step; // T
  int table_entries;
  // Whether pictures with pixels of 2 T and more are drawn from coarser levels; X-rays always are. They lose
  // what classification makes of fine detail.
  bool coarse_levels;
  bool smooth_edges; // of isosurfaces
  // Steps of this many T and more are drawn with flat_kernel() in shaded composites, and with short_kernel()
  // elsewhere, without shading from twice that on.
  double flat_kernel, short_kernel;
};
inline constexpr double never_short = 1e30; // T
[[nodiscard]] constexpr QualitySettings quality_settings(Quality quality) {
  switch (quality) {
  case Quality::draft:
    return {.sheet_step = 1,
            .table_entries = 1024,
            .coarse_levels = true,
            .smooth_edges = false,
            .flat_kernel = 0.5,
            .short_kernel = 0.5};
  case Quality::normal:
    return {.sheet_step = 0.5,
            .table_entries = 2048,
            .coarse_levels = true,
            .smooth_edges = true,
            .flat_kernel = 0.5,
            .short_kernel = 0.5};
  case Quality::fine:
    return {.sheet_step = 0.25,
            .table_entries = 4096,
            .coarse_levels = false,
            .smooth_edges = true,
            .flat_kernel = 0,
            .short_kernel = never_short};
  case Quality::best:
    break;
  }
  return {.sheet_step = 0.125,
          .table_entries = 8192,
          .coarse_levels = false,
          .smooth_edges = true,
          .flat_kernel = 0,
          .short_kernel = never_short};
}

} // namespace bccsplat
