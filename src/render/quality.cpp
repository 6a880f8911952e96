// SPDX-License-Identifier: Apache-2.0
#include "render/quality.h"

namespace bccsplat {
namespace {

// The settings are points of the front of error against time, `bccsplat_bench render --front --own`
// (tests/bench/notes/render.md). Differences span pixels: they know less of the field the larger a pixel is,
// but cost a twentieth of the picture where the kernel's gradient doubles it, and smooth its ripple. Each
// limit is where the two meet against the truth. The short kernel saves time and loses accuracy on fields
// near the band limit, so that the two accurate settings do without. Coarser levels lose what classification
// makes of fine detail, so that these settings do without them, too; and the shading of coarser levels shows
// the ripple of the exact kernel.
//
// Shaded pictures of raised sheets are as near to the truth as those of sheets at the pixels: just below 1.5
// samples per T the window of a kernel of radius 2 is 6 x 6. They pay as soon as windows at the pixels would
// be larger than 8 x 8. Unshaded pictures and rays that graze an isosurface show the filter's error: they are
// raised with more taps, from more samples, or not at all. Two sheets per T hold what finer sheets of shaded
// pictures need.
constexpr RaiseFilter coarse{.taps = 6, .density = 1.49, .from = 1.35, .from_general = 1.2};
constexpr RaiseFilter medium{.taps = 6, .density = 1.74, .from = 1.25, .from_general = 1.2};
constexpr RaiseFilter dense{.taps = 8, .density = 1.99, .from = 1.35, .from_general = 1.2};
constexpr RaiseFilter close{.taps = 8, .density = 1.99, .from = 1.35, .from_general = 1.2, .depth = 2};
constexpr RaiseFilter long_taps{.taps = 8, .density = 1.49, .from = 1.35, .from_general = 1.2};
constexpr double never = 1e30; // T

constexpr QualitySettings draft{.sheet_step = 1,
                                .table_entries = 1024,
                                .analytic_below = 1.1,
                                .coarse_levels = true,
                                .flat_kernel = 0.5,
                                .short_kernel = 0.5,
                                .raise = coarse,
                                .raise_unshaded = medium,
                                .raise_surface = long_taps,
                                .smooth_edges = false};
constexpr QualitySettings normal{.sheet_step = 0.5,
                                 .table_entries = 2048,
                                 .analytic_below = 1.1,
                                 .coarse_levels = true,
                                 .flat_kernel = 0.5,
                                 .short_kernel = 0.5,
                                 .raise = coarse,
                                 .raise_unshaded = dense,
                                 .raise_surface = dense,
                                 .smooth_edges = true};
constexpr QualitySettings fine{.sheet_step = 0.25,
                               .table_entries = 4096,
                               .analytic_below = 1.1,
                               .coarse_levels = false,
                               .flat_kernel = 0,
                               .short_kernel = never,
                               .raise = close,
                               .raise_unshaded = {},
                               .raise_surface = {},
                               .smooth_edges = true};
constexpr QualitySettings best{.sheet_step = 0.125,
                               .table_entries = 8192,
                               .analytic_below = 1.25,
                               .coarse_levels = false,
                               .flat_kernel = 0,
                               .short_kernel = never,
                               .raise = close,
                               .raise_unshaded = {},
                               .raise_surface = {},
                               .smooth_edges = true};

} // namespace

QualitySettings quality_settings(Quality quality) {
  switch (quality) {
  case Quality::draft:
    return draft;
  case Quality::normal:
    return normal;
  case Quality::fine:
    return fine;
  case Quality::best:
    break;
  }
  return best;
}

} // namespace bccsplat
