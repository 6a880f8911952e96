// SPDX-License-Identifier: Apache-2.0
#include "splat/sheet_settings.h"

#include "view/sheet_metric.h"

namespace bccsplat {
namespace {

// What a quality means to sheets.
struct SheetQuality {
  // Pixels per T: below it gradients are the kernel's own, from there on fourth-order differences.
  double analytic_below;
  // How sheets are raised where samples are shaded, where they are not, and in isosurfaces.
  RaiseFilter raise, raise_unshaded, raise_surface;
};

// The settings are points of the front of error against time, `bccsplat_bench render --front --own`
// (tests/bench/notes/render.md). Differences span pixels: they know less of the field the larger a pixel is,
// but cost a twentieth of the picture where the kernel's gradient doubles it, and smooth its ripple. Each
// limit is where the two meet against the truth. The short kernel saves time and loses accuracy on fields
// near the band limit, so that the two accurate settings do without. The shading of coarser levels shows the
// ripple of the exact kernel, so that these settings do without levels (draw/quality.h).
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

SheetQuality sheet_quality(Quality quality) {
  switch (quality) {
  case Quality::draft:
    return {.analytic_below = 1.1, .raise = coarse, .raise_unshaded = medium, .raise_surface = long_taps};
  case Quality::normal:
    return {.analytic_below = 1.1, .raise = coarse, .raise_unshaded = dense, .raise_surface = dense};
  case Quality::fine:
    return {.analytic_below = 1.1, .raise = close, .raise_unshaded = {}, .raise_surface = {}};
  case Quality::best:
    break;
  }
  return {.analytic_below = 1.25, .raise = close, .raise_unshaded = {}, .raise_surface = {}};
}

// Pixels per unit: from as near as this their differences drown in the rounding of floats.
constexpr double analytic_above = 4096;

} // namespace

SplatOptions sheet_options(const Shot& shot) {
  const SheetQuality quality = sheet_quality(shot.quality);
  const SheetWishes none, &wishes = shot.wishes ? *shot.wishes : none;
  SplatOptions o;
  static_cast<ShotOptions&>(o) = shot.options;
  // Labels are where the field that reaches them is another.
  if (shot.slice->labels && o.mode == RenderMode::composite)
    o.disable_skips |= skip_transfer_function | skip_cells | skip_empty_sheets;
  const double pixels = pixels_per_unit(*shot.view);
  o.gradient = wishes.gradient.value_or(pixels < quality.analytic_below || pixels > analytic_above
                                            ? GradientMethod::analytic
                                            : GradientMethod::fourth_order);
  // The analytic sums know nothing of the lattice sum that such kernels divide by, nor of corrections.
  if ((shot.slice->kernel.normalised || corrected(shot)) && o.gradient == GradientMethod::analytic)
    o.gradient = GradientMethod::fourth_order;
  o.kernel_form = wishes.kernel_form.value_or(sample_form(shot));
  o.raise = wishes.raise.value_or(o.mode == RenderMode::isosurface               ? quality.raise_surface
                                  : o.mode == RenderMode::composite && o.shading ? quality.raise
                                                                                 : quality.raise_unshaded);
  return o;
}

} // namespace bccsplat
