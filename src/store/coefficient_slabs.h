// SPDX-License-Identifier: Apache-2.0
// Slabs of samples in, slabs of prefiltered coefficients out: the stage between fit and file of a volume that
// stores coefficients.
#pragma once

#include <memory>
#include <vector>

#include "base/context.h"
#include "fit/coefficient_layers.h"
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
  // of coefficients are made as soon as they can be, for they take less than the samples that they are made
  // of, and stored when a slab of samples is complete: the order of a file's slabs is that of whole slabs.
  void add_layers(int channel, int32_t first, const SlabLayers& samples, const Context& context,
                  const FitSink& store);
  // Stores what is left of a channel.
  void finish(int channel, const Context& context, const FitSink& store);

 private:
  struct Channel {
    CoefficientLayers maker;
    bool begun = false;
    std::vector<CoefficientSlab> slabs; // made and not stored
  };
  void make(Channel& c, const Context& context) const;
  void store_made(int channel, const FitSink& store);

  int32_t layers_, slab_layers_;
  bool periodic_;
  std::vector<std::unique_ptr<Channel>> channels_;
};

} // namespace bccsplat
