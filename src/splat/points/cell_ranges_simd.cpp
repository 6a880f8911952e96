// SPDX-License-Identifier: Apache-2.0
// The loop of cell_ranges.h through Highway: one body is compiled for every target, and the best is chosen at
// run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/points/cell_ranges_simd.cpp"
#include <hwy/foreach_target.h>
// Highway's target list must come before anything it guards.
#include <hwy/highway.h>

#include "splat/points/cell_ranges.h"

HWY_BEFORE_NAMESPACE();
namespace bccsplat {
namespace HWY_NAMESPACE {
namespace {

#if HWY_TARGET == HWY_SCALAR
void Widen(CellCube& cube, const WidenedCells& out) { widen_cells_reference(cube, out); }
#else

namespace hn = hwy::HWY_NAMESPACE;

struct Least {
  template<class V> V operator()(V a, V b) const { return hn::Min(a, b); }
};
struct Greatest {
  template<class V> V operator()(V a, V b) const { return hn::Max(a, b); }
};

// Puts the extreme of each cell and its neighbours along the three axes into the cell; rows y and z from
// -halo on are right afterwards. At the ends of rows along x wrong values come in from outside, one cell
// farther with each call; none of the cells that are used is reached.
template<class Extreme> void WidenByOne(CellCube::Field& field, int halo, const Extreme& extreme) {
  constexpr int side = CellCube::side, pitch = CellCube::pitch;
  const hn::CappedTag<float, pitch> d;
  CellCube::Field along_x, along_y;
  const int before = -halo - 1, end = 4 + halo;
  const auto each = [&](int z0, int z1, int y0, int y1, const auto& body) {
    for (int z = z0; z < z1; ++z)
      for (int y = y0; y < y1; ++y) {
        const size_t row = CellCube::at(-CellCube::before, y, z);
        for (size_t i = 0; i < pitch; i += hn::Lanes(d)) body(row + i);
      }
  };
  const auto three = [&](const CellCube::Field& from, size_t n, size_t beside) {
    const float* const p = from.data() + n;
    return extreme(extreme(hn::LoadU(d, p - beside), hn::LoadU(d, p)), hn::LoadU(d, p + beside));
  };
  each(before, end + 1, before, end + 1,
       [&](size_t n) { hn::StoreU(three(field, n, 1), d, along_x.data() + n); });
  each(before, end + 1, -halo, end,
       [&](size_t n) { hn::StoreU(three(along_x, n, pitch), d, along_y.data() + n); });
  each(-halo, end, -halo, end,
       [&](size_t n) { hn::StoreU(three(along_y, n, pitch * side), d, field.data() + n); });
}

void Widen(CellCube& cube, const WidenedCells& out) {
  for (size_t r = 0; r < out.size(); ++r) {
    const int halo = CellCube::margin - 1 - static_cast<int>(r);
    WidenByOne(cube.low, halo, Least{}), WidenByOne(cube.high, halo, Greatest{});
    for (int z = 0; z < 4; ++z)
      for (int y = 0; y < 4; ++y) {
        const size_t from = CellCube::at(0, y, z);
        CellRange* const to = out[r] + (y << 2 | z << 4);
        for (size_t x = 0; x < 4; ++x) to[x] = {cube.low[from + x], cube.high[from + x]};
      }
  }
}

#endif

} // namespace
} // namespace HWY_NAMESPACE
} // namespace bccsplat
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bccsplat {
HWY_EXPORT(Widen);

void widen_cells(CellCube& cube, const WidenedCells& out) { HWY_DYNAMIC_DISPATCH(Widen)(cube, out); }

} // namespace bccsplat
#endif
