// SPDX-License-Identifier: Apache-2.0
// Slabs of samples in, slabs of prefiltered coefficients out: the stage between fit and file of a volume that
// stores coefficients.
#pragma once

#include <memory>
#include <vector>

#include "base/context.h"
#include "fit/coefficients/coefficient_layers.h"
#include "fit/fit.h"
#include "store/series_part.h"

namespace bccsplat {

class CoefficientSlabs {
 public:
  // info: says how each channel is coded, and of which kernel the coefficients are. part: null for a whole
  // series.
  CoefficientSlabs(const Lattice4& lattice, const VolumeInfo& info, const SeriesPart* part);
  // The series, a whole one, ends elsewhere than was said.
  void set_lattice(const Lattice4& lattice);

  // The next layers of samples of a channel, `first` and up, of which none is held elsewhere for long. Slabs
  // of coefficients are made and stored as soon as they can be.
  void add_layers(int channel, int32_t first, const SlabLayers& samples, const Context& context,
                  const FitSink& store);
  // Makes and stores the slabs of a channel that depend on nothing still to come: at the end of its data all
  // that are left.
  void store_ready(int channel, const Context& context, const FitSink& store);

 private:
  struct Channel {
    CoefficientLayers maker;
    bool begun = false;
  };

  int32_t slab_layers_;
  bool periodic_;
  std::vector<std::unique_ptr<Channel>> channels_;
};

} // namespace bccsplat
