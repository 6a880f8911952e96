// SPDX-License-Identifier: Apache-2.0
// How far the content of a series reaches in frequency, all four axes together, and what lies where a lattice
// does not keep it.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "bccsplat.h"
#include "choose/sample.h"

namespace bccsplat::series {

// Mean square of the values by frequency, means of blocks taken off: cosine transforms of blocks of the
// sample. Axes that a block has whole are mirrored at their ends if lattices do so; along others it has a
// Hann window. Frequencies are fractions of the Nyquist frequency of the source, 0 .. 1, along x, y, z, t.
class Spectrum {
 public:
  // air: by channel, in the place of what is not finite. Channels count in units of their range. faces,
  // ends, periodic: as of a lattice; what is predicted or goes round is mirrored along no axis.
  Spectrum(const SeriesDescription& series, const SeriesSample& sample, const std::vector<double>& air,
           int32_t faces, int32_t ends, int32_t periodic, Watch& watch);

  [[nodiscard]] bool empty() const { return total_ <= 0; }
  // Below which `part` of the energy lies along an axis; 0 for an axis too short to tell.
  [[nodiscard]] double percentile(size_t axis, double part) const;
  // Part of the energy outside the 24-cell |f_i| + |f_j| <= sqrt2 of D4* (static: the rhombic dodecahedron of
  // BCC) of lattice distance 1.
  [[nodiscard]] double outside() const;
  // Resolution along an axis, as a fraction of Nyquist; 0: not measured.
  [[nodiscard]] double resolution(size_t axis) const;

  // A bin with something in it.
  struct Bin {
    std::array<uint8_t, 4> at{}; // number of its frequency along each axis
    double energy = 0;           // mean square over that of the range
  };
  [[nodiscard]] const std::vector<Bin>& bins() const { return bins_; }
  // Numbers of frequencies along an axis, and the frequencies.
  [[nodiscard]] size_t count(size_t axis) const { return count_[axis]; }
  [[nodiscard]] double frequency(size_t axis, size_t number) const {
    return count_[axis] == 1 ? 0 : static_cast<double>(number) / static_cast<double>(count_[axis] - 1);
  }

 private:
  std::array<size_t, 4> count_{1, 1, 1, 1}; // bins along each axis
  std::array<bool, 4> windowed_{};
  std::vector<Bin> bins_;
  double total_ = 0;
};

} // namespace bccsplat::series
