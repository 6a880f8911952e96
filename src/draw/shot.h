// SPDX-License-Identifier: Apache-2.0
// One view of one slice, settled: what is seen, with nothing left to choose but how a drawer draws it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "draw/quality.h"
#include "field/lattice_sums.h"
#include "field/slice.h"
#include "kernel/drawn_kernel.h"
#include "shade/class_table.h"
#include "shade/iso_surface.h"
#include "shade/light.h"
#include "shade/mode.h"
#include "shade/preintegrate.h"
#include "shade/transfer_function.h"
#include "view/view.h"

namespace bccsplat {

class KeptPoints;   // splat/points/kept_points.h
class LightVolume;  // shade/light_volume.h
struct GpuTarget;   // gpu/gpu_info.h
struct SheetWishes; // splat/sheet_settings.h
struct SplatPoints; // splat/points/points.h

enum SkipBits : uint32_t {    // of ShotOptions::disable_skips
  skip_transfer_function = 1, // bricks, and with them cells
  skip_frustum = 2,
  skip_occlusion = 4,
  skip_empty_sheets = 8,
  skip_fine_detail = 16, // detail finer than half a pixel, by a coarser level of the slice
  skip_unchanged = 32,   // points of a view whose sheets were kept
  skip_cells = 64,       // invisible parts of bricks that are visible
};

// A pixel this opaque is taken for finished: what is behind would add at most 0.005 of its light.
inline constexpr double default_opacity_stop = 0.995;

// The sheets that a kernel's ball reaches over at most: a view's step is no finer.
inline constexpr int most_sheets_in_reach = 256;

struct ShotOptions {
  RenderMode mode = RenderMode::composite;
  bool shading = true;
  std::vector<IsoSurface> surfaces;           // mode isosurface: those with an opacity; none are alike
  double opacity_stop = default_opacity_stop; // a pixel this opaque is finished; 1: never
  uint32_t disable_skips = 0;
  int tile_size = 0; // pixels; 0: chosen
  bool with_depth = true, with_value = false, with_time = false;
  float depth_opacity =
      0.5f;                  // at which the depth of a pixel is that of the ray; of surfaces the first counts
  bool with_deep = false;    // modes composite and isosurface
  bool with_hits = false;    // mode isosurface: every hit is handed on with a tile
  double deep_tolerance = 0; // see DeepTile
  bool without_ripple = false; // lit without that of the kernel: surfaces, maxima, analytic gradients
};

enum class TrailCombine : uint8_t {
  physical = 1,   // extinctions add along the ray
  interleaved = 2 // Neophytou & Mueller 2002, equation (8), sheet by sheet as printed
};

struct SheetShare {
  uint32_t source = 0;
  float weight = 1;
};

// One moment of a trail: its field is a weighted sum of sources. Where there are several shares, the sources
// are time slices of one lattice and `frame` is the moment's; one share is the source alone, with weight 1
// and its own time.
struct ShotStill {
  std::span<const SheetShare> shares;
  size_t function = 0; // number of its transfer function
  float weight = 1;    // of its extinction; those of a trail sum to 1
  double frame = 0;
};

// A trail that is drawn with the slice into one picture.
struct ShotTrail {
  struct Source {
    const Slice* slice = nullptr;
    const SplatPoints* points = nullptr;
    const SheetView* view = nullptr; // the shot's, or moved to a domain of its own
  };
  std::vector<Source> sources;
  std::vector<ShotStill> stills;
  std::span<const TransferFunction> functions;
  std::vector<ClassTable> tables; // of the functions, without integrals
  TrailCombine combine = TrailCombine::physical;
  bool unlit = false; // whatever the slice is
};

// Another field, seen by the same rays and on the same sheets: where the shot's own field absorbs, or has a
// surface, the colour is that of this one's value. What it absorbs is nothing.
struct ShotPaint {
  const Slice* slice = nullptr;
  const KeptPoints* points = nullptr; // as of a shot
  const SheetView* view = nullptr;
  const TransferFunction* function = nullptr; // its colours
  const ClassTable* table = nullptr;          // of them; every entry absorbs, so that all of it is looked at
};

struct Shot {
  const Slice* slice = nullptr;
  const KeptPoints* points = nullptr; // kept with the slice; null: what is made of it is for this picture
  const SheetView* view = nullptr;
  const TransferFunction* function = nullptr;
  const ClassTable* table = nullptr; // of the function over the slice's values, without integrals
  const Lights* lights = nullptr;
  bool noise_of_ripple = false; // beside that of the lights: what the kernel's ripple makes of gradients
  double voxel = 1;             // world length of a mean voxel of the source, whatever the slice's level
  Quality quality = Quality::normal;
  Preintegrate preintegrate = Preintegrate::automatic;
  ShotOptions options;
  const SheetWishes* wishes = nullptr; // null: sheets are drawn as the quality asks
  const ShotTrail* trail = nullptr;    // null: none
  const ShotPaint* paint = nullptr;    // null: the colours are those of its own values
  const LightVolume* light = nullptr;  // what of the lights comes through; null: all
  const GpuTarget* target = nullptr;   // a texture that pixels go to instead of being emitted
  KeptLatticeSums* sums = nullptr;     // of earlier pictures; null: none are kept
};

// What is drawn into one picture: a shot, or several of mode composite whose views have the same pixels and
// sheets, each of its own lattice.
using Shots = std::span<const Shot* const>;

// Returns the world length of one mean voxel of the slice's source, the default unit distance.
[[nodiscard]] double mean_voxel(const Slice& slice);
// Returns how many samples of slice space a slice has along each axis of its lattice.
[[nodiscard]] Vec3 samples_across(const Slice& slice);
[[nodiscard]] bool one_sample_thick(const Slice& slice);

// Returns the lights with the noise of the kernel in this form, where the shot asks for it.
[[nodiscard]] Lights lights_of(const Shot& shot, KernelForm form = KernelForm::exact);

// Returns the form of the kernel that the samples of a shot are drawn with, by its mode, quality and step.
// Surfaces and maxima are then found by the kernel itself.
[[nodiscard]] KernelForm sample_form(const Shot& shot);

// Returns whether corrections are in any of the fields that are drawn.
[[nodiscard]] bool corrected(const Shot& shot);

} // namespace bccsplat
