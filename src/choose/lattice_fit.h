// SPDX-License-Identifier: Apache-2.0
// What a lattice is likely to lose of a spectrum, and the distances that lose least.
#pragma once

#include <array>
#include <cstdint>

#include "choose/beyond.h"
#include "choose/spectrum.h"

namespace bccsplat::series {

// What lattices see of a series that they continue so.
struct Spectra {
  Spectrum plain, faces, all;
  [[nodiscard]] const Spectrum& of(Beyond beyond) const {
    return beyond == Beyond::plain ? plain : beyond == Beyond::faces ? faces : all;
  }
};

// Mean square error, over the square of the range, that a spectrum predicts for the default kernel and
// filter.
[[nodiscard]] double predicted_error(const Spectrum& spectrum, const LatticeShape& shape,
                                     const std::array<uint64_t, 4>& dims);

// The lattice of about `density` sites per source sample with the least error predicted.
[[nodiscard]] LatticeShape fit_lattice(const Spectrum& spectrum, int32_t lattice, double density,
                                       const std::array<uint64_t, 4>& dims, Watch& watch);

} // namespace bccsplat::series
