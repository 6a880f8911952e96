// Lattices with a distance for each axis: how they come out, what they are likely to lose of a spectrum, and
// the distances that lose least.
#pragma once

#include <array>
#include <cstdint>
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
// What may be done beyond the ends: as a writer does unasked, or as given; faces predicted; the ends of time,
// too.
enum class Beyond : uint8_t { plain, faces, all };
inline constexpr std::array kBeyond{Beyond::plain, Beyond::faces, Beyond::all};
// What is given stays, and samples of the source need nothing outside.
[[nodiscard]] LatticeShape with_beyond(LatticeShape shape, Beyond beyond);
// Do writers of a series do the same for both?
[[nodiscard]] bool goes_on_alike(const LatticeShape& a, const LatticeShape& b,
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

// What lattices see of a series that they continue so.
struct Spectra {
  Spectrum plain, faces, all;
  [[nodiscard]] const Spectrum& of(Beyond beyond) const {
    return beyond == Beyond::plain ? plain : beyond == Beyond::faces ? faces : all;
  }
};

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
