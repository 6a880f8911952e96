// How far the content of a series reaches in frequency, measured on windowed blocks, and what that means for
// the choice of lattice.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tool/import/sample.h"
#include "tool/json.h"

namespace bcc4 {

// Energy by frequency, the mean of each block taken off. Frequencies are fractions of the Nyquist frequency
// of the source, 0 .. 1, along x, y, z, t.
class Spectrum {
 public:
  // Blocks of up to 32 samples along each axis, Hann windows; what is not finite becomes air.
  Spectrum(const std::vector<SampleStretch>& sample, const std::vector<double>& air);

  [[nodiscard]] bool empty() const { return total_ <= 0; }
  // Below which `part` of the energy lies along an axis; 0 for an axis too short to tell.
  [[nodiscard]] double percentile(size_t axis, double part) const;
  // Part of the energy outside the 24-cell |f_i| + |f_j| <= sqrt2 of D4* (static: the rhombic dodecahedron of
  // BCC) when the lattice is stretched by `scale` in space and `time_scale` in time.
  [[nodiscard]] double outside(double scale, double time_scale) const;
  // Resolution along an axis: the width of the window's main lobe, as a fraction of Nyquist; 0: not measured.
  [[nodiscard]] double resolution(size_t axis) const;

 private:
  std::array<size_t, 4> n_{1, 1, 1, 1}; // samples of a block
  std::vector<double> energy_;          // by |frequency| bins, n/2 + 1 per axis, x fastest
  double total_ = 0;
};

struct SpectrumAdvice {
  double time_scale = 1; // the coarsest that loses next to nothing
  double scale = 1;
  bool cartesian = false; // much energy lies where D4* folds it
};
[[nodiscard]] SpectrumAdvice advise_lattice(const Spectrum& spectrum, uint64_t frames);

[[nodiscard]] std::vector<std::string> spectrum_lines(const Spectrum& spectrum, uint64_t frames);
[[nodiscard]] Json spectrum_json(const Spectrum& spectrum, uint64_t frames);

} // namespace bcc4
