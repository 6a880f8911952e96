// Image-aligned sheet-buffer splatting: the points of a slice, drawn tile by tile, front to back.
//
// Per tile a ring of live sheets gathers the kernels of the points; a sheet that no later point can reach is
// classified, shaded and composited. Every pixel closes by itself, every sample adds its points in one order
// (slab, brick, place in the brick) and positions come from tile-independent integers and fractions: the
// picture does not depend on tile size or threads, bit for bit. Sources: Westover 1990; Mueller, Shareef,
// Huang, Crawfis 1999 (sheets, post-classification); Neophytou & Mueller 2002.
#pragma once

#include <cstdint>
#include <functional>

#include "base/context.h"
#include "field/slice.h"
#include "splat/loop/kernels.h"
#include "splat/points/points.h"
#include "splat/raise/raise.h"
#include "splat/shade/class_table.h"
#include "splat/shade/light.h"
#include "splat/tile/deep.h"
#include "splat/view/view.h"

namespace bccsplat {

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

struct SplatOptions {
  RenderMode mode = RenderMode::composite;
  bool shading = true;
  GradientMethod gradient = GradientMethod::analytic;
  double iso_value = 0;
  double opacity_stop = 0.995; // a pixel this opaque is finished; 1: never
  uint32_t disable_skips = 0;
  int tile_size = 0; // pixels; 0: chosen
  bool with_value = false, with_time = false;
  bool with_deep = false;                     // modes composite and isosurface
  double deep_tolerance = 0;                  // see DeepTile
  KernelForm kernel_form = KernelForm::exact; // how the slice's kernel is drawn
  bool preintegrate = false; // mode composite: slabs are classified by the table's integrals, which are there
  RaiseFilter raise;         // where sheets need fewer samples than the picture has pixels
  bool scalar = false;       // the plain inner loops
};

struct SplatScene {
  const Slice* slice = nullptr;
  const SplatPoints* points = nullptr;
  const SheetView* view = nullptr;
  const ClassTable* table = nullptr;
  const Lights* lights = nullptr;
};

// A finished tile: planes of `pitch` floats per row. depth is in sheet steps (infinity: nothing), value and
// time are NaN where nothing is.
struct TilePixels {
  int x = 0, y = 0, width = 0, height = 0, pitch = 0;
  const float *red = nullptr, *green = nullptr, *blue = nullptr, *alpha = nullptr;
  const float *depth = nullptr, *value = nullptr, *time = nullptr;
  const DeepTile* deep = nullptr; // null: not asked for
};

struct SplatStats {
  double ms_transform = 0, ms_splat = 0, ms_shade = 0; // summed over threads
  uint64_t points_after_cull = 0, points_splatted = 0, points_occluded = 0;
  uint64_t points_invisible = 0; // visits of points in cells that nothing visible looks at
  uint64_t bricks_invisible = 0, bricks_outside = 0, sheets_skipped = 0;
  uint64_t tiles = 0, sheets = 0;
  uint64_t sheets_taken = 0;  // of tiles, from those that were kept
  uint64_t contributions = 0; // window samples (pixels x sheets) the splat loop went through
};

// Adds what a tile counted.
void add(SplatStats& sum, const SplatStats& part);

class KeptSheets;

// `emit` is called once per tile, from any thread. kept: from picture to picture; null: nothing is.
SplatStats splat(const SplatScene& scene, const SplatOptions& options, const Context& context,
                 const std::function<void(const TilePixels&)>& emit, KeptSheets* kept = nullptr);

} // namespace bccsplat
