// SPDX-License-Identifier: Apache-2.0
// Lattices with a distance for each axis, and how they come out.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "bccsplat.h"

namespace bccsplat::series {

using Distances = std::array<double, 4>; // x, y, z in source samples, t in frames

struct LatticeShape {
  int32_t lattice = BCCSPLAT_LATTICE_D4STAR; // D4STAR (BCC: the same without time) or CC
  Distances scales{1, 1, 1, 1};
  int32_t faces = BCCSPLAT_FACES_DEFAULT; // what is done at the faces
  int32_t ends = BCCSPLAT_ENDS_DEFAULT;   // and at the ends of time
  int32_t periodic = 0;                   // axes of space: BCCSPLAT_PERIODIC_...
  bool operator==(const LatticeShape&) const = default;
};

[[nodiscard]] bool is_bcc(const LatticeShape& shape); // or D4*
// Are its sites samples of the source in space, at the frames it has? Are those frames of the source?
[[nodiscard]] bool has_source_planes(const LatticeShape& shape);
[[nodiscard]] bool has_source_frames(const LatticeShape& shape);
// Does an axis of space go round?
[[nodiscard]] constexpr bool is_periodic(int32_t periodic, size_t axis) {
  return (periodic >> axis & 1) != 0;
}
// Does it have the samples of the source themselves?
[[nodiscard]] bool is_source_grid(const LatticeShape& shape);
// The number of the last plane of an axis of n samples.
[[nodiscard]] double last_plane(const LatticeShape& shape, size_t axis, uint64_t n);
// Distances as a writer realises them: in space a whole number of planes ends on the last sample,
// or is a turn.
[[nodiscard]] Distances realised_distances(const LatticeShape& shape, const std::array<uint64_t, 4>& dims);
// Returns what a part of a series, of `part` samples, takes to be like the whole: along the axes that are cut
// planes as far from each other as those of the series, as nearly as a whole number of them allows. A part
// that ends with the series has its last layer as far behind the last frame.
[[nodiscard]] LatticeShape shape_of_part(const LatticeShape& shape, const std::array<uint64_t, 4>& dims,
                                         const std::array<uint64_t, 4>& part, bool ends_with_series);
// Layers of a series, none of them beyond its ends.
[[nodiscard]] uint64_t inner_layers(const LatticeShape& shape, const std::array<uint64_t, 4>& dims);
// Sites per source sample, without those outside the faces and layers beyond the ends of time.
[[nodiscard]] double site_density(const LatticeShape& shape, const std::array<uint64_t, 4>& dims);

// The same shape coarser: so many times fewer sites.
[[nodiscard]] LatticeShape scaled_shape(LatticeShape shape, double fewer,
                                        const std::array<uint64_t, 4>& dims);
// The one with all distances alike.
[[nodiscard]] LatticeShape cubic_lattice(int32_t lattice, double density,
                                         const std::array<uint64_t, 4>& dims);

// "d4star, distances 1 x 0.7 x 0.85 x 2.3, ends predicted", as realised.
[[nodiscard]] std::string shape_text(const LatticeShape& shape, const std::array<uint64_t, 4>& dims);

} // namespace bccsplat::series
