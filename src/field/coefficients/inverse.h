// SPDX-License-Identifier: Apache-2.0
// The prefilter of kernel exact: it inverts, along x, y, z and t, what the kernel makes of coefficients at
// the sites of a Cartesian lattice (PrefilterStage in kernel/kernel.h).
#pragma once

#include <map>
#include <utility>
#include <vector>

#include "base/context.h"
#include "field/coefficients/prefilter.h"
#include "kernel/kernel.h"
#include "points/brick.h"
#include "points/sample_source.h"

namespace bccsplat {

class InversePrefilter {
 public:
  // space: the stage with a pole; time: weights of the layers around one, which has the middle one.
  InversePrefilter(const PrefilterStage& space, std::vector<float> time)
      : space_(space), weights_(std::move(time)) {}

  // Prefilters one layer as Prefilter::apply does.
  [[nodiscard]] SampleLayer apply(int32_t layer, const Lattice4& lattice,
                                  const std::map<int32_t, const SampleLayer*>& samples,
                                  const CoefficientForm& form, const BrickBox& region,
                                  const Context& context) const;
  // The same of a layer that has been summed over time, whose bricks are written over where nobody else has
  // them.
  [[nodiscard]] SampleLayer apply_in_space(BrickLayer layer, const CoefficientForm& form,
                                           const BrickBox& region, const Context& context) const;

 private:
  [[nodiscard]] BrickLayer sum_layers(int32_t layer, const Lattice4& lattice,
                                      const std::map<int32_t, const SampleLayer*>& samples,
                                      const BrickBox& region, const Context& context) const;

  PrefilterStage space_;
  std::vector<float> weights_;
};

} // namespace bccsplat
