// SPDX-License-Identifier: Apache-2.0
// The lattice that a series is stored on where nobody says it, and the precision of its values: what its
// spectrum predicts, proved on a sample.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "choose/lattice_fit.h"
#include "choose/trial.h"

namespace bccsplat::series {

// What is to be decided.
struct LatticeWish {
  std::vector<int32_t> lattices{BCCSPLAT_LATTICE_D4STAR, BCCSPLAT_LATTICE_CC}; // among these
  double density = 0.5;                                                        // sites per source sample
  int32_t faces = BCCSPLAT_FACES_DEFAULT;                                      // DEFAULT: what does best
  int32_t ends = BCCSPLAT_ENDS_DEFAULT;                                        // the same
  int32_t periodic = 0;                                                        // axes of space
  // Distances that were given, or the grid of the source: the lattice is not chosen but proved.
  std::optional<LatticeShape> fixed;
  std::vector<bool> labels{}; // by channel: is not rounded
};

struct LatticeCandidate {
  std::string name; // "d4star, cubic"
  LatticeShape shape;
  Beyond beyond = Beyond::plain;
  double predicted = 0;             // dB, by the spectrum alone
  std::optional<CodingTrial> trial; // on the sample, values as exact as the source's; none: it cannot be best
};

struct LatticeChoice {
  std::vector<LatticeCandidate> candidates;
  size_t best = 0;
  double half_the_frames = 0; // dB of every second frame, those between blended
  CodingTrial rounded;        // the best one with the steps it is stored in
  uint64_t sampled_frames = 0;
  std::vector<bool> labels{}; // by channel
  bool takes_less = false;    // the source's grid, which takes less than wavelets of the usual error
  [[nodiscard]] const LatticeCandidate& chosen() const { return candidates[best]; }
};

// Tries the shapes that lose least of the spectrum, and the cubic D4*.
[[nodiscard]] LatticeChoice choose_lattice(Trier& trier, const Spectra& spectra, const LatticeWish& wish,
                                           const SeriesDescription& series);

// Steps whose rounding adds at most a fifteenth to the error that a trial has, by channel; never finer than
// the source's own, and of at most 1/512 of the range in the field, root mean square. Labels have none.
[[nodiscard]] std::vector<StepCoding>
worthwhile_steps(const CodingTrial& trial, const SeriesDescription& series, const WriterSettings& settings,
                 const std::vector<ChannelScan>& ranges, const std::vector<bool>& labels);

} // namespace bccsplat::series
