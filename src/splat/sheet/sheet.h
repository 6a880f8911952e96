// SPDX-License-Identifier: Apache-2.0
// What happens to a finished sheet of a tile: it is classified, shaded and composited, or integrated, or the
// maximum is kept.
//
// A sheet represents a segment of every ray, from half a step before it to half a step behind it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/grid.h"
#include "draw/pixel_planes.h"
#include "field/lattice_sums.h"
#include "shade/class_table.h"
#include "shade/light.h"
#include "view/pixel_rect.h"

namespace bccsplat {

// The world gradient follows from three sums of a sample: of the analytic gradient di, dj
// and dk, else the differences of the field per pixel and per sheet. From the last of these the part that is
// due to the ray's slant, in pixels per sheet, is taken off.
struct GradientBasis {
  std::array<float, 3> x{}, y{}, z{}; // of a length near 1
  float unit = 1; // a power of two: the sums times this are near 1, too, and have squares that are floats
  double enlarged = 1;                    // what comes of them is so many times the world gradient
  float slant_x = 0, slant_y = 0;         // at pixel (0, 0) of the picture
  float slant_per_x = 0, slant_per_y = 0; // more per pixel (perspective)
};

// The segments that a sheet stands for, in steps of the sheets.
struct SheetSegments {
  float k = 0;        // sheet number
  float front = 0.5f; // they begin this much before k, those of the first sheet at the eye
  [[nodiscard]] float begin() const { return k - front; }
  [[nodiscard]] float end() const { return k + 0.5f; }
};

// The tile's place in the picture and the shapes of its planes.
struct SheetTile {
  int x = 0, y = 0, width = 0, height = 0;
  int pitch = 0;               // of PixelPlanes and holes
  int plane_pitch = 0;         // of the planes of sheets, which have a border
  PixelRect seen = all_pixels; // pixels of the tile outside of it are the base, which is invisible
  // Returns the place of pixel (x, y) of the tile in a plane of pixels, or of sheets from its first pixel on.
  [[nodiscard]] size_t pixel(int column, int row) const { return plane_index(column, row, pitch); }
  [[nodiscard]] std::ptrdiff_t sample(int column, int row) const {
    return plane_offset(column, row, plane_pitch);
  }
};

struct SheetField {
  // Values relative to the base of the field, from the tile's first pixel on, inside a plane with a border.
  const float* value = nullptr;
  float base = 0;
  float above_air = 0; // the base less air, which mode xray integrates from
};

// Gradients by differences: the sheets k - 1 and k + 1, k - 2 and k + 2, and the factor of each pair's
// difference.
struct SheetDifferences {
  int neighbours = 0; // on either side that are looked at, 1 or 2; 0: gradients are analytic
  const float *before = nullptr, *after = nullptr, *before2 = nullptr, *after2 = nullptr;
  float depth_scale = 0, depth_scale2 = 0;
  // Whether before and after tell how gradients change within the segment, which is then lit in halves.
  bool halves = false;
};

// The places of a sheet's samples in the cells of the lattice, whose ripple is taken off analytic gradients.
struct SheetRipple {
  const LatticeSums* sums = nullptr; // null: it is left in them
  // The place of the picture's first pixel, so that tiles do not matter, and the steps to the pixels right of
  // and below it, in cells.
  std::array<float, 3> at{}, per_x{}, per_y{};
  // The sums of a sample that a gradient per lattice unit is, by its parts.
  std::array<float, 3> sum_i{}, sum_j{}, sum_k{};
};

// Gradients by the sums of the kernel's own gradient.
struct SheetSums {
  const float *i = nullptr, *j = nullptr, *k = nullptr;
  SheetRipple ripple{};
};

// How values become colours and opacities.
struct SheetClasses {
  const ClassTable* table = nullptr;
  // The table's entries, in an orthographic view, with the opacity of a whole sheet in place of the
  // extinction; null: none.
  const std::array<float, 4>* whole = nullptr;
  float stop = 1;        // a pixel this opaque is finished
  float depth_at = 0.5f; // where a pixel becomes this opaque its depth is
};

struct SheetShading {
  bool on = false;
  // Orthographic: the direction to the viewer that all rays share.
  bool alike = false;
  Vec3 to_viewer{};
  const Lights* lights = nullptr;
  float noise = 0, noise_of_value = 0; // of the lights, enlarged as gradients are
};

// What the tile's pixels have from elsewhere, planes pitched as PixelPlanes.
struct SheetPaint {
  const float* value = nullptr; // that pixels are classified by, absolute; null: the field's
  const float *red = nullptr, *green = nullptr, *blue = nullptr; // null: the table's colours
  // The shares of light that come through: from all around, and from each light, whose planes are
  // `light_floats` apart; null: all of it.
  const float *ambient = nullptr, *lights = nullptr;
  size_t light_floats = 0;
};

// A value between sheets: the weighted sum of four planes.
struct Halfway {
  std::array<const float*, 4> plane{};
  std::array<float, 4> weight{};
};

// Segments are classified by the table's integrals, the value running linearly from half a sheet before k to
// k and on to half a sheet behind it. Samples more than `known` sheets outside the domain are not looked at.
struct SheetHalves {
  bool preintegrated = false; // false: by the entry of the value at k
  float known = 0;
  Halfway front{}, back{};
};

struct SheetArgs {
  SheetSegments segment{};
  SheetTile tile{};
  SheetField field{};
  SheetDifferences differences{};
  SheetSums analytic{};
  GradientBasis basis{}; // of the gradients of either kind
  SheetClasses classes{};
  SheetShading shading{};
  SheetHalves halves{};
  SheetPaint paint{};            // of absorb() alone (splat/sheet/matter.h)
  const uint8_t* hole = nullptr; // per pixel, `pitch` per row; null: none
  std::array<float, 4> time{};   // frame index at (i, j): [0] + [1] i + [2] j
  PixelPlanes pixel{};
  // Pixels are those of the tile.
  [[nodiscard]] float time_at(int column, int row) const {
    return time[0] + time[1] * static_cast<float>(tile.x + column) +
           time[2] * static_cast<float>(tile.y + row);
  }
};

// A pixel of the tile whose field passes the target between two sheets, or may pass it twice there, which
// neither sheet shows: the field comes closer to it at the one and goes away at the other, and the tangents
// meet beyond it.
struct SheetCrossing {
  uint16_t x = 0, y = 0;
  uint8_t interval = 0; // of CrossingArgs
  bool grazes = false;
  bool operator==(const SheetCrossing&) const = default;
};

// Looks for `target` (relative to the base) at pixels inside the domain and not yet finished.
struct CrossingArgs {
  static constexpr int most = 4;
  int count = 1; // intervals: number n runs from sheet k - 1 + n to k + n
  float k = 0, target = 0;
  float stop = 1; // a pixel this opaque is finished
  int width = 0, height = 0, pitch = 0;
  PixelRect seen = all_pixels;              // outside of it all sheets are the base
  std::array<const float*, most + 3> plane; // sheets k - 2 .. k + count
  int plane_pitch = 0;
  const float *alpha = nullptr, *enter = nullptr, *leave = nullptr;
  SheetCrossing* found = nullptr; // room for every pixel and interval; rows, columns and intervals rise
};

struct SheetLoops {
  // Composites sheets one behind the other that differ in number, planes, basis (not where rays are alike),
  // holes and time only: pixels are read and written once for all of them. Returns the number of pixels that
  // closed.
  int (*composite)(std::span<const SheetArgs>);
  // Mode xray: adds to pixel.red (the integral), and where times are asked for to pixel.time, weighted by
  // |value - air|, and to pixel.alpha, the sum of the weights.
  void (*integrate)(const SheetArgs&);
  size_t (*crossings)(const CrossingArgs&); // returns how many it found
  // Mode maximum: keeps the largest value so far in pixel.red and its sheet in pixel.depth.
  void (*maximum)(const SheetArgs&);
};

[[nodiscard]] const SheetLoops& reference_sheet_loops();

// What a segment absorbs, and in which part of it.
struct Segment {
  std::array<float, 3> color{};
  float absorbed = 0, value = 0;
  float depth = 0;                   // optical
  float begin = 0, weight = 0;       // sheets
  float front = 0, front_weight = 0; // of them before the sheet itself, where that is known apart
};
// Classifies the segment of pixel p, `at` in the sheet's planes, all extinctions times `share`.
[[nodiscard]] Segment classify_pixel(const SheetArgs& sheet, size_t p, std::ptrdiff_t at, float share = 1);

// The part of the segment [k - front, k + 1/2] inside the domain at pixel p.
[[nodiscard]] float segment_weight(const SheetArgs& sheet, size_t p);
// `quarters` of a sheet's distance behind the sheet, along the ray: from -1 to 1, 0 unless
// differences.halves.
[[nodiscard]] Vec3 world_gradient(const SheetArgs& sheet, int x, int y, float quarters = 0);

// Where smoke is dense and turns within a step, light by one gradient per sheet shows the sheets as contours.
// Segments that add more than this to the opacity of a pixel are lit by two gradients, a quarter of a sheet
// before and behind, each for the half that it is in the middle of; the two move apart as more is added, and
// are there from twice this on.
inline constexpr float lit_in_halves = 0.02f;

// Light on the segment at pixel (x, y), which adds `added` to the opacity.
[[nodiscard]] Shading light_segment(const SheetArgs& sheet, int x, int y, const Segment& segment,
                                    float added);
[[nodiscard]] const SheetLoops& simd_sheet_loops(); // best target of this machine

} // namespace bccsplat
