// What happens to a finished sheet of a tile: classify, shade, composite; or integrate, or keep the maximum.
//
// A sheet stands for a segment of every ray: from half a step before it to half a step behind it.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "splat/shade/class_table.h"
#include "splat/shade/light.h"
#include "splat/view/pixel_rect.h"

namespace bccsplat {

// Planes of the pixels of a tile, `pitch` floats per row.
struct PixelPlanes {
  // So far: premultiplied colour and opacity; depth in sheet steps where the opacity passed 1/2; sums
  // weighted by opacity.
  float *red = nullptr, *green = nullptr, *blue = nullptr, *alpha = nullptr;
  float *depth = nullptr, *value = nullptr, *time = nullptr; // value, time: null when not asked for
  // The ray: sheet numbers where it enters and leaves the domain, world length per sheet step, direction to
  // the viewer.
  const float *enter = nullptr, *leave = nullptr, *path = nullptr;
  const float *view_x = nullptr, *view_y = nullptr, *view_z = nullptr;
};

// Direction of the world gradient from the sums of a sample: analytic: di, dj, dk; else the differences of
// the field per pixel and per sheet, of which the part of the ray within the sheet, slant pixels per sheet,
// is taken off the last.
struct GradientBasis {
  std::array<float, 3> x{}, y{}, z{}; // of a length near 1: only the direction of a gradient is asked for
  float unit = 1; // a power of two: the sums times this are near 1, too, and have squares that are floats
  float slant_x = 0, slant_y = 0;         // at pixel (0, 0) of the picture
  float slant_per_x = 0, slant_per_y = 0; // more per pixel (perspective)
};

// A value between sheets: the weighted sum of four planes.
struct Halfway {
  std::array<const float*, 4> plane{};
  std::array<float, 4> weight{};
};

struct SheetArgs {
  float k = 0;        // sheet number
  float front = 0.5f; // the segment begins this much before k, that of the first sheet at the eye
  int x = 0, y = 0;   // of the tile in the picture
  int width = 0, height = 0, pitch = 0;
  PixelRect seen = all_pixels; // pixels of the tile outside of it are the base, which is invisible
  // Relative to the base of the field; points at the tile's first pixel inside a plane with a border.
  const float* value = nullptr;
  // Differences: the sheets k - 1 and k + 1, k - 2 and k + 2, with what each pair's difference counts.
  const float *before = nullptr, *after = nullptr, *before2 = nullptr, *after2 = nullptr;
  float depth_scale = 0, depth_scale2 = 0;
  const float *sum_i = nullptr, *sum_j = nullptr, *sum_k = nullptr; // analytic
  int plane_pitch = 0;
  bool central = false;      // differences over one neighbour
  bool fourth_order = false; // and over two
  bool shading = false;
  float base = 0, stop = 1;
  float above_air = 0; // the base less air, which mode xray integrates from
  const ClassTable* table = nullptr;
  const Lights* lights = nullptr;
  GradientBasis basis;
  // Segments are classified by the table's integrals, the value running linearly from half a sheet before k
  // to k and on to half a sheet behind it. Samples more than `known` sheets outside the domain stand for
  // nothing.
  bool preintegrated = false;
  Halfway front_half, back_half;
  float known = 0;
  // Orthographic: the direction to the viewer that all rays share.
  bool alike = false;
  Vec3 to_viewer{};
  // Then: the table's entries with the opacity of a whole sheet in place of the extinction; null: none.
  const std::array<float, 4>* whole = nullptr;
  const uint8_t* hole = nullptr; // per pixel, `pitch` per row; null: none
  std::array<float, 4> time{};   // frame index at (i, j): [0] + [1] i + [2] j
  PixelPlanes pixel;
};

// A pixel of the tile whose field passes the target between two sheets, or may pass it twice there, which
// neither shows: it comes closer at the one and goes away at the other, and the tangents meet beyond it.
struct SheetCrossing {
  uint16_t x = 0, y = 0;
  uint8_t interval = 0; // of CrossingArgs
  bool grazes = false;
  bool operator==(const SheetCrossing&) const = default;
};

// Looks for `target` (relative to the base) at pixels inside the domain and not yet covered.
struct CrossingArgs {
  static constexpr int most = 4;
  int count = 1; // intervals: number n runs from sheet k - 1 + n to k + n
  float k = 0, target = 0;
  int width = 0, height = 0, pitch = 0;
  PixelRect seen = all_pixels;              // outside of it all sheets are the base
  std::array<const float*, most + 3> plane; // sheets k - 2 .. k + count
  int plane_pitch = 0;
  const float *alpha = nullptr, *enter = nullptr, *leave = nullptr;
  SheetCrossing* found = nullptr; // room for every pixel and interval; rows, columns and intervals rise
};

struct SheetLoops {
  // Sheets one behind the other that differ in number, planes, basis (not where rays are alike), holes and
  // time only: pixels are read and written once for all of them. Returns the number of pixels that closed.
  int (*composite)(std::span<const SheetArgs>);
  // Mode xray: into pixel.red (integral) and pixel.time (weighted by |value - air|).
  void (*integrate)(const SheetArgs&);
  size_t (*crossings)(const CrossingArgs&); // returns how many it found
  // Into pixel.red (largest value so far) and pixel.depth (its sheet).
  void (*maximum)(const SheetArgs&);
};

[[nodiscard]] const SheetLoops& reference_sheet_loops();

// The part of the segment [k - front, k + 1/2] inside the domain at pixel p.
[[nodiscard]] float segment_weight(const SheetArgs& sheet, size_t p);
[[nodiscard]] Vec3 world_gradient(const SheetArgs& sheet, int x, int y); // of any length
[[nodiscard]] const SheetLoops& simd_sheet_loops();                      // best target of this machine

} // namespace bccsplat
