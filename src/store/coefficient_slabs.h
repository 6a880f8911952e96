// SPDX-License-Identifier: Apache-2.0
// Slabs of samples in, slabs of prefiltered coefficients out: the stage between fit and file of a volume that
// stores coefficients.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "base/context.h"
#include "fit/coefficient_layers.h"
#include "fit/coefficient_steps.h"
#include "fit/fit.h"
#include "store/series_part.h"

namespace bccsplat {

class CoefficientSlabs {
 public:
  // info: says how each channel is coded, and of which kernel the coefficients are. part: null for a whole
  // series.
  CoefficientSlabs(const Lattice4& lattice, const VolumeInfo& info, const SeriesPart* part);
  // The series, a whole one, ends elsewhere than was said.
  void set_lattice(const Lattice4& lattice, const VolumeInfo& info);

  // The next layers of samples of a channel, `first` and up; `store` is called for each slab that is complete
  // with them.
  void add_layers(int channel, int32_t first, const SlabLayers& samples, const Context& context,
                  const FitSink& store);

 private:
  struct Channel {
    template<class... Layers>
    explicit Channel(int32_t first_slab, const Layers&... layers) : maker(layers...), next_slab(first_slab) {}
    CoefficientLayers maker;
    int32_t next_slab;
    bool begun = false;
    std::vector<BrickLayer> slab; // layers made and not stored
    std::optional<CoefficientSteps> steps;
  };
  int32_t layers_, slab_layers_;
  bool periodic_;
  std::vector<std::unique_ptr<Channel>> channels_;
};

} // namespace bccsplat
