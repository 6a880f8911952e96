// SPDX-License-Identifier: Apache-2.0
// The baseline of the renderer: a ray-marcher over a dense Cartesian grid, with macro cells that the transfer
// function skips, early ray termination and packets of rays in vectors. Camera, transfer function, opacity
// correction and shading are those of the splatter; samples stand on the same sheets.
//
// Trilinear: gradients are central differences of the grid, interpolated. Tricubic: cubic B-splines whose
// coefficients, made beforehand, interpolate the samples; gradients are theirs. Sources: Levoy 1990 (early
// termination), Deakin & Knoll 2019 (distances between macro cells), Wald et al. 2005 (packets, refined
// hits), Unser 1999 (the recursive prefilter).
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "scene/picture.h"
#include "tests/bench/ray_march/ray_march_packet.h"

namespace bccsplat::bench {

enum class Interpolation : uint8_t { trilinear, tricubic };

// Samples in index space, or the coefficients of splines through them, x fastest, continued by two mirrored
// ones at every end, so that neither interpolation nor differences ask where they are.
struct MarchGrid {
  static constexpr int pad = 2, cell_edge = 8; // samples
  Int3 dims{}, cells{};
  size_t row = 0, plane = 0;    // floats to the next row, the next plane
  size_t origin = 0;            // of sample (0, 0, 0)
  std::vector<float> value;     // one float more than needed: rows are read in pairs
  std::vector<float> low, high; // per macro cell: bounds of what interpolation inside it gives
  Interpolation interpolation = Interpolation::trilinear;

  [[nodiscard]] size_t at(int x, int y, int z) const {
    return static_cast<std::ptrdiff_t>(origin) + x + y * static_cast<std::ptrdiff_t>(row) +
           z * static_cast<std::ptrdiff_t>(plane);
  }
};
[[nodiscard]] MarchGrid make_march_grid(const Int3& dims,
                                        const std::function<double(double x, double y, double z)>& field,
                                        Interpolation interpolation = Interpolation::trilinear);

struct MarchOptions {
  RenderMode mode = RenderMode::composite; // or isosurface
  bool shading = true;
  double step = 1; // distance of samples along the view direction, index units
  double iso_value = 0;
  double opacity_stop = 0.995;
  int table_entries = 2048;
  bool skip = true; // macro cells
};

// What depends on transfer function or iso value, not on the camera: per macro cell the distance, in cells
// and in the maximum norm, to the next one that may show something; 0 for those that may.
[[nodiscard]] std::vector<uint8_t> march_distances(const MarchGrid& grid, const TransferFunction& function,
                                                   const MarchOptions& options);

// The grid's place and what is drawn of it. Index space is world space.
struct MarchScene {
  const MarchGrid* grid = nullptr;
  const std::vector<uint8_t>* distance = nullptr; // of march_distances
  Camera camera;
  TransferFunction function;
  Lights lights;
};

// Fills the RGBA plane.
void ray_march(const MarchScene& scene, const MarchOptions& options, const Context& context, Image& image);
// The same picture in double precision, ray by ray, without skipping: what the fast one is tested against.
void ray_march_reference(const MarchScene& scene, const MarchOptions& options, Image& image);

// The value at a point in [0, dims - 1] by the formula, in double precision, and the gradient unless null.
[[nodiscard]] double march_value(const MarchGrid& grid, const Vec3& p, Vec3* gradient = nullptr);
// The same as the marcher computes it; false where it has no vectors to do so.
[[nodiscard]] bool march_values(const MarchGrid& grid, std::span<const MarchPoint> points,
                                std::span<MarchFieldValue> values);

// What both need: a slice without points that stands where the grid does.
[[nodiscard]] Slice grid_domain(const MarchGrid& grid);
[[nodiscard]] ClassTable march_table(const MarchScene& scene, const MarchOptions& options);

} // namespace bccsplat::bench
