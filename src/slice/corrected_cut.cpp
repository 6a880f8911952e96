// SPDX-License-Identifier: Apache-2.0
// Puts the corrections of a file into slices that are no moments: they are compared with the volume's field
// at points of a grid, and corrected by what they lack there.
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/would_block.h"
#include "field/corrections.h"
#include "field/evaluate.h"
#include "field/sample_grid.h"
#include "slice/corrected_slice.h"
#include "slice/thick_field.h"

namespace bccsplat {
namespace {

constexpr uint64_t points_at_once = 1 << 20;
// A slice is mended where it is off by more than this part of a step of the file's corrections.
constexpr double mended_part = 1.0 / 32;

// The grid whose points are mended, and the field that the slice should have there.
class Mending {
 public:
  Mending(const Slice& slice, const Coefficients& coefficients, const Thickness& thickness)
      : slice_(slice), coefficients_(coefficients), thickness_(thickness),
        thick_(coefficients, slice.hyperplane, thickness) {
    for (size_t a = 0; a < 3; ++a) {
      const double unit = slice.lattice_to_slice.linear[a][a];
      origin_[a] = slice.lattice_to_slice.offset[a] + unit * slice.domain_begin[a];
      const double length = unit * (slice.domain_end[a] - slice.domain_begin[a]);
      dims_[a] = static_cast<int32_t>(std::floor(length + touches_end)) + 1;
    }
    const Lattice4& lattice = coefficients.source().lattice();
    for (size_t a = 0; a < 4; ++a) end_[a] = lattice.domain_end(a);
  }
  [[nodiscard]] const Vec3& origin() const { return origin_; }
  [[nodiscard]] const Int3& dims() const { return dims_; }

  // Adds what these rows lack of these planes.
  void rows(std::array<int32_t, 2> y, std::array<int32_t, 2> z, const Context& context,
            std::vector<GridValue>& add, std::vector<GridValue>& set) const {
    Grid grid;
    grid.origin = origin_ + Vec3{0, static_cast<double>(y[0]), static_cast<double>(z[0])};
    grid.dims = {dims_[0], y[1] - y[0], z[1] - z[0]};
    const auto nx = static_cast<size_t>(grid.dims[0]), ny = static_cast<size_t>(grid.dims[1]);
    const size_t count = nx * ny * static_cast<size_t>(grid.dims[2]);
    std::vector<float> own(count), field(count);
    sample_grid(slice_, grid, own.data(), context);
    volume_field(grid, field, context);
    const double least = mended_part * coefficients_.corrections()->step();
    for (size_t i = 0; i < count; ++i) {
      const Int3 at{static_cast<int32_t>(i % nx), y[0] + static_cast<int32_t>(i / nx % ny),
                    z[0] + static_cast<int32_t>(i / (nx * ny))};
      const float lacks = field[i] - own[i];
      if (std::isnan(own[i])) {
        if (!std::isnan(field[i]) && slice_.has_holes) set.push_back({at, field[i]});
      } else if (std::fabs(static_cast<double>(lacks)) > least) {
        add.push_back({at, lacks});
      }
    }
  }

 private:
  // Sets the volume's values at the grid, absolute; NaN outside the domain and in holes.
  void volume_field(const Grid& grid, std::vector<float>& field, const Context& context) const {
    std::vector<Vec4> points(field.size());
    const auto nx = static_cast<size_t>(grid.dims[0]), ny = static_cast<size_t>(grid.dims[1]);
    for (size_t i = 0; i < points.size(); ++i) {
      const Vec3 uvw = grid.origin + Vec3{static_cast<double>(i % nx), static_cast<double>(i / nx % ny),
                                          static_cast<double>(i / (nx * ny))};
      for (size_t a = 0; a < 4; ++a) {
        double p = slice_.origin[a];
        for (size_t k = 0; k < 3; ++k) p += slice_.basis[k][a] * uvw[k];
        if (p < 0 && p > -touches_end) p = 0;
        if (p > end_[a] && p < end_[a] + touches_end) p = end_[a];
        points[i][a] = p;
      }
    }
    if (thickness_.length == 0) {
      evaluate4(coefficients_, points, field, {}, context);
      return;
    }
    std::vector<uint8_t> holes(points.size());
    thick_.values(points, field, holes, context);
    for (size_t i = 0; i < field.size(); ++i)
      field[i] = holes[i] ? std::numeric_limits<float>::quiet_NaN() : field[i] + thick_.base();
  }

  const Slice& slice_;
  const Coefficients& coefficients_;
  Thickness thickness_;
  ThickField thick_;
  Vec3 origin_;
  Int3 dims_;
  Vec4 end_{};
};

} // namespace

void correct_slice(Slice& slice, const Coefficients& coefficients, const Thickness& thickness,
                   const Context& context) {
  const Corrections* fix = coefficients.corrections();
  if (!fix || slice.empty()) return;
  const Mending mending(slice, coefficients, thickness);
  const Int3& dims = mending.dims();
  // As many points at once as may be: each time layers are made anew that do not stay.
  const uint64_t plane = static_cast<uint64_t>(dims[0]) * static_cast<uint64_t>(dims[1]);
  const auto rows = static_cast<int32_t>(
                 std::clamp<uint64_t>(points_at_once / static_cast<uint64_t>(dims[0]), 1, dims[1])),
             planes = static_cast<int32_t>(std::clamp<uint64_t>(points_at_once / plane, 1, dims[2]));
  std::vector<GridValue> add, set;
  Attempts attempts;
  for (int32_t z = 0; z < dims[2]; z += planes)
    for (int32_t y = 0; y < dims[1]; y += rows) {
      const int32_t z1 = std::min(z + planes, dims[2]), y1 = std::min(y + rows, dims[1]);
      const auto part = [&](int32_t z_part, int32_t y_part) {
        return (z_part + static_cast<double>(y_part) / dims[1]) / dims[2];
      };
      Progress share(context.progress, part(z, y), y1 < dims[1] ? part(z, y1) : part(z1, 0));
      attempts.attempt([&] { mending.rows({y, y1}, {z, z1}, context.with(share), add, set); });
    }
  attempts.throw_if_waiting();
  set_corrections(slice,
                  {mending.origin(), fix->shape(), SparseGrid(std::move(add)), SparseGrid(std::move(set))});
}

} // namespace bccsplat
