// SPDX-License-Identifier: Apache-2.0
// The inner loops of the splatter and the data they share: one body for every SIMD target (*_simd.cpp), and a
// slow reference that reads like the formulae (reference.cpp).
//
// Gap s holds the points between sheets s and s + 1. Their kernels reach the sheets first .. last of that
// gap, a window of at most `sheets` sheets, a multiple of 4. Sheet k lives in slot k mod sheets of the
// ring: group slot / 4, lane slot % 4, so that four neighbouring pixels of one group are 16 floats
// side by side:
//   ring[group][y][x][lane]
// and one vector adds to 4 sheets x 4 pixels whatever the alignment in x.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/vec.h"
#include "kernel/drawn_kernel.h"
#include "splat/raise/raise.h"

namespace bccsplat {

inline constexpr int max_ring_sheets = 256; // most_sheets_in_reach of draw/shot.h
// Isotropic windows of up to this many pixels a side are drawn by blocks, others are large: at 16 x 16 blocks
// take 44 ns per point, pairs of vectors with rows of their own 54 (tests/bench/notes/splat.md).
inline constexpr int block_window = 16;

// phi(u) and its derivative in u as float polynomials.
struct KernelPolynomial {
  enum class Form : uint8_t {
    general,
    square_8,   // a_2 u^2 + ... + a_7 u^7
    short_form, // a_2 u^2 + a_4 u^4 + a_5 u^5
    flat_form   // a_2 u^2 + a_4 u^4
  };
  Form form = Form::general;
  int terms = 0;
  std::array<float, RadialKernel::max_terms> a{};     // of u^j
  std::array<float, RadialKernel::max_terms> slope{}; // of u^j in d phi / du: (j + 1) a[j + 1]
};
// Returns the polynomial of phi in a form, or of phi itself where it has no such form.
[[nodiscard]] KernelPolynomial kernel_polynomial(const RadialKernel& phi,
                                                 KernelForm form = KernelForm::exact);

// Constants of one gap, per ring slot. With the pixel distances from the foot of a point on sheet k,
// di = i - fx - X delta and dj = j - fy - Y delta:
//   u = 1 - (xx di^2 + xy di dj + yy dj^2) - depth2 (offset - z)^2
struct GapLanes {
  const float* offset = nullptr; // k - s
  const float* delta = nullptr;  // shift of the foot from sheet s to sheet k, per unit of X, Y
  const float *xx = nullptr, *xy = nullptr, *yy = nullptr; // 1 / (R pixel)^2
  const float* reach = nullptr; // xx - xy^2 / (4 yy): no row is in reach of columns where reach di^2 >= 1
  // Rows that the sheets of a group may reach in an isotropic window; null: all rows. A large window has them
  // per four columns, 4 n .. 4 n + 3, begin and end at [(group * row_columns + n) * 2]; any other window for
  // all columns together, at [group * 2].
  const int16_t* row_range = nullptr;
  int row_columns = 0;
  const int16_t* group_rows = nullptr;
};

// A point in a bin. The window starts at pixel (x, y) of the tile's ring, possibly outside of it.
struct SplatRecord {
  float fx, fy; // foot on sheet s, pixels from the start of the window
  float z;      // depth beyond sheet s, in sheet steps, in [0, 1)
  float c;      // coefficient
  int32_t x, y;
  float lateral_x, lateral_y; // X, Y
};

struct SplatArgs {
  const SplatRecord* record = nullptr;
  size_t count = 0;
  const GapLanes* lanes = nullptr;
  const KernelPolynomial* kernel = nullptr;
  float depth2 = 0;
  bool isotropic = false;    // xx, yy equal for all lanes, xy and delta 0
  int columns = 0, rows = 0; // of the window, pixels
  float half = 0;            // isotropic: the kernel's radius, pixels
  bool spare = false; // the ring has spare pixels for whole windows around the tile: nothing need be clipped
  std::array<float*, 4> ring{}; // value, and with gradients the sums of c phi'(u) times di, dj, offset - z
  int groups = 0;
  size_t group_floats = 0; // distance of groups
  int pitch = 0; // pixels per ring row: a multiple of 16 and spare pixels, at least 4 on either side
  int width = 0, height = 0; // of the tile with its border, pixels
};

// Moves the points of a brick to the screen. Pixel and sheet numbers are relative to integer bases, so that
// float holds them as exactly far from the origin as near it.
struct BrickAxes {
  int32_t i = 0, j = 0;                  // base pixel
  int64_t k = 0;                         // base sheet
  std::array<float, 4> di{}, dj{}, dk{}; // per local plane x, y, z, and constant
  std::array<float, 4> dX{}, dY{};       // lateral coordinates, the same
  float m = 0;                           // `lateral` table at the base: foot = di.. + X (lateral[s] - m)
};

// What a tile sees of gaps that a fan is raised from.
struct FanArgs {
  const int32_t* rect = nullptr; // per gap, from base_gap: samples of the ring that it needs: x begin,
                                 // y begin, x end, y end
  // 1 / scale of the nearest and the farthest sheet that the points of each gap reach.
  const float *inverse_near = nullptr, *inverse_far = nullptr;
  // The pixel of the tile where a sample of the ring lies is foot + (sample - sample_foot) per / scale.
  float per_x = 1, per_y = 1, foot_x = 0, foot_y = 0;
  int sample_foot_x = 0, sample_foot_y = 0;
  int around = 0;            // samples
  int border = 0;            // pixels
  int width = 0, height = 0; // of the tile, pixels: what open_sum counts
};

// The part of the gaps' plan that moving points need: tables from gap `base` on.
struct GapTables {
  int64_t base = 0;
  const float* lateral = nullptr;
  const float* half_x = nullptr; // half windows, pixels
  const float* half_y = nullptr;
  const int32_t* columns = nullptr; // windows, pixels
  const int32_t* rows = nullptr;
};

// The ring of a tile that points are moved to.
struct TileWindow {
  int x = 0, y = 0; // pixel of ring column 0, row 0
  int width = 0, height = 0;
  // How many pixels before column x and row y are still open, (width + 1) sums per row; null: all are open. A
  // point is dropped when no pixel of its window, or within `around` of it, is open.
  const int32_t* open_sum = nullptr;
  int around = 0;
  const FanArgs* fan = nullptr; // then open_sum counts pixels
};

struct TransformArgs {
  const uint16_t* position = nullptr;
  const float* coefficient = nullptr;
  size_t count = 0;
  const BrickAxes* axes = nullptr;
  // Bit (x >> 2 | y >> 2 << 2 | z >> 2 << 4) of the local planes: points there are needed.
  uint64_t cells = ~uint64_t{0};
  bool isotropic = false;
  GapTables gaps;
  int64_t first_gap = 0, last_gap = 0; // points outside of them are dropped
  TileWindow tile;
  // Results: accepted points are appended at bin_end[(gap - gaps.base) & bin_mask]; every bin has room for
  // count + 1.
  SplatRecord** bin_end = nullptr;
  uint32_t bin_mask = 0; // bin_end[bin_mask + 1] takes what is rejected
};

struct TransformCounts {
  size_t accepted = 0, occluded = 0, invisible = 0; // invisible: of all points, wherever they fall
};

// Copies one finished sheet out of the ring into rows of pixels and clears its slot of the ring.
struct ExtractArgs {
  float* ring = nullptr; // the slot's group
  int lane = 0;
  int pitch = 0, width = 0, height = 0;
  float* plane = nullptr;
  int plane_pitch = 0;
};

struct SplatLoops {
  void (*splat)(const SplatArgs&);
  TransformCounts (*transform)(const TransformArgs&);
  void (*extract)(const ExtractArgs&);
  void (*raise)(const RaiseArgs&);
  void (*blend)(const BlendArgs&);
};

// Adds points to the ring with the best target of this machine.
void splat_points(const SplatArgs& args);

[[nodiscard]] const SplatLoops& reference_loops();
[[nodiscard]] const SplatLoops& simd_loops(); // best target of this machine

} // namespace bccsplat
