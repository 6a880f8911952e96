// SPDX-License-Identifier: Apache-2.0
// What a picture shows and how it is drawn.
#pragma once

#include <cstdint>
#include <vector>

#include "field/lattice_sums.h"
#include "field/slice.h"
#include "splat/loop/loops.h"
#include "splat/points/points.h"
#include "splat/raise/raise.h"
#include "splat/shade/class_table.h"
#include "splat/shade/iso_surface.h"
#include "splat/shade/light.h"
#include "splat/view/view.h"

namespace bccsplat {

class KeptSurfaceCells;

enum class RenderMode : uint8_t { composite = 1, isosurface = 2, xray = 3, maximum = 4 };
// The kernel's own gradient, or differences of the sheets' samples over one or two neighbours on either side.
enum class GradientMethod : uint8_t { analytic, central, fourth_order };

enum SkipBits : uint32_t {    // of SplatOptions::disable_skips
  skip_transfer_function = 1, // bricks, and with them cells
  skip_frustum = 2,
  skip_occlusion = 4,
  skip_empty_sheets = 8,
  skip_unchanged = 32, // points of a view whose sheets were kept
  skip_cells = 64,     // invisible parts of bricks that are visible
};

// A pixel this opaque is taken for finished: what is behind would add at most 0.005 of its light.
inline constexpr double default_opacity_stop = 0.995;

struct SplatOptions {
  RenderMode mode = RenderMode::composite;
  bool shading = true;
  GradientMethod gradient = GradientMethod::analytic;
  std::vector<IsoSurface> surfaces;           // mode isosurface: those with an opacity; none are alike
  double opacity_stop = default_opacity_stop; // a pixel this opaque is finished; 1: never
  uint32_t disable_skips = 0;
  int tile_size = 0; // pixels; 0: chosen
  bool with_value = false, with_time = false;
  bool with_deep = false;                     // modes composite and isosurface
  bool with_hits = false;                     // mode isosurface: every hit is handed on with a tile
  double deep_tolerance = 0;                  // see DeepTile
  KernelForm kernel_form = KernelForm::exact; // how the slice's kernel is drawn
  bool preintegrate = false;                  // mode composite: by the table's integrals, which are there
  bool without_ripple = false;  // lit without that of the kernel: surfaces, maxima, analytic gradients
  RaiseFilter raise;            // where sheets need fewer samples than the picture has pixels
  bool rays = true;             // where rays_cover() holds; else sheets
  bool reference_loops = false; // slow ones that read like the formulae
};

struct SplatScene {
  const Slice* slice = nullptr;
  const SplatPoints* points = nullptr; // null where rays draw
  const SheetView* view = nullptr;
  const ClassTable* table = nullptr;
  const Lights* lights = nullptr;
  KeptLatticeSums* sums = nullptr;   // of earlier pictures; null: none are kept
  KeptSurfaceCells* cells = nullptr; // the same of rays
};

} // namespace bccsplat
