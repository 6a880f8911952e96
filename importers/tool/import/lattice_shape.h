// Lattices with a distance for each axis: how they come out, what they are likely to lose of a spectrum, and
// the distances that lose least.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "bccsplat.h"
#include "tool/import/spectrum.h"

namespace bcc4 {

using Distances = std::array<double, 4>; // x, y, z in source samples, t in frames

struct LatticeShape {
  int32_t lattice = BCCSPLAT_LATTICE_D4STAR; // D4STAR (BCC: the same without time) or CC
  Distances scales{1, 1, 1, 1};
  int32_t faces = BCCSPLAT_FACES_DEFAULT; // what is done at the faces
  int32_t ends = BCCSPLAT_ENDS_DEFAULT;   // and at the ends of time
  bool operator==(const LatticeShape&) const = default;
};

// What lattices see of a series: with ends as they are unasked, or as given, and predicted.
struct Spectra {
  Spectrum plain, predicted;
  [[nodiscard]] const Spectrum& of(const LatticeShape& shape) const {
    return shape.faces == BCCSPLAT_FACES_PREDICT || shape.ends == BCCSPLAT_ENDS_PREDICT ? predicted : plain;
  }
};

// Does it have the samples of the source themselves?
[[nodiscard]] bool is_source_grid(const LatticeShape& shape);
// Distances as a writer realises them: in space a whole number of planes ends on the last sample.
[[nodiscard]] Distances realised_distances(const LatticeShape& shape, const std::array<uint64_t, 4>& dims);
// What a part of a series, of `part` samples, takes to be like the whole: along the axes that are cut planes
// as far from each other as those of the series, as nearly as a whole number of them allows. A part that ends
// with the series has its last layer as far behind the last frame.
[[nodiscard]] LatticeShape shape_of_part(const LatticeShape& shape, const std::array<uint64_t, 4>& dims,
                                         const std::array<uint64_t, 4>& part, bool ends_with_series);
// What a writer of a series of `dims` does at its faces, in words that mean the same for a part of it.
[[nodiscard]] int32_t faces_of_part(const LatticeShape& shape, const std::array<uint64_t, 4>& dims);
// Does a writer of a series of `dims` predict what lies beyond its ends?
[[nodiscard]] bool predicts_ends(const LatticeShape& shape, const std::array<uint64_t, 4>& dims);
// The same with faces and ends predicted, or none if a writer does that anyway or it tells nothing of the
// source's samples.
[[nodiscard]] std::optional<LatticeShape> with_ends_predicted(const LatticeShape& shape,
                                                              const std::array<uint64_t, 4>& dims);
// Layers of a series, none of them beyond its ends.
[[nodiscard]] uint64_t inner_layers(const LatticeShape& shape, const std::array<uint64_t, 4>& dims);
// Sites outside the faces and the ends of time, over those inside, where faces are predicted `across`
// (faces_of_part) and ends or not.
[[nodiscard]] double outside_share(const LatticeShape& shape, const std::array<uint64_t, 4>& dims,
                                   int32_t across, bool ends);
[[nodiscard]] double outside_share(const LatticeShape& shape, const std::array<uint64_t, 4>& dims);
// Sites per source sample, without those outside the faces and layers beyond the ends of time.
[[nodiscard]] double site_density(const LatticeShape& shape, const std::array<uint64_t, 4>& dims);

// Mean square error, over the square of the range, that a spectrum foretells for the default kernel and
// filter.
[[nodiscard]] double foretold_error(const Spectrum& spectrum, const LatticeShape& shape,
                                    const std::array<uint64_t, 4>& dims);

// The lattice of about `density` sites per source sample with the least error foretold.
[[nodiscard]] LatticeShape fit_lattice(const Spectrum& spectrum, int32_t lattice, double density,
                                       const std::array<uint64_t, 4>& dims);
// The same in coarser: so many times fewer sites.
[[nodiscard]] LatticeShape scaled_shape(LatticeShape shape, double fewer,
                                        const std::array<uint64_t, 4>& dims);
// The one with all distances alike.
[[nodiscard]] LatticeShape cubic_lattice(int32_t lattice, double density,
                                         const std::array<uint64_t, 4>& dims);

// "d4star, distances 1 x 0.7 x 0.85 x 2.3, ends predicted", as realised.
[[nodiscard]] std::string shape_text(const LatticeShape& shape, const std::array<uint64_t, 4>& dims);

} // namespace bcc4
