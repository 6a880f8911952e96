// SPDX-License-Identifier: Apache-2.0
// All stages of a prefilter at once, for some layers: plane by plane along z, in rings of planes that stay in
// the processor's caches, so that only samples are read and only coefficients are written.
//
// Stage j of layer m reads stage j-1 and the samples of layers m-2 .. m+2. What several layers depend on is
// made once for all of them, and made again at the next call.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <vector>

#include "base/context.h"
#include "kernel/kernel.h"
#include "points/brick.h"
#include "points/sample_source.h"

namespace bccsplat {

// Makes stage j + 1 of stage j; its samples are those of stage `source`.
struct PrefilterStep {
  PrefilterStage filter;
  int source = 0;
};

// What coefficients become when they are made: those up to `prune` in magnitude (value units) are dropped; of
// the others bricks are rounded to steps as coarse as `coarsest` where these suffice
// (points/rounded_brick.h); 0: none are.
struct CoefficientForm {
  float prune = 0, coarsest = 0;
};

class InversePrefilter; // inverse.h

class Prefilter {
 public:
  Prefilter(const Lattice4& lattice, std::vector<PrefilterStep> steps)
      : lattice_(lattice), steps_(std::move(steps)) {}

  [[nodiscard]] bool empty() const { return steps_.empty(); }
  // The layers of samples that coefficients of these layers depend on; all are inside the lattice.
  [[nodiscard]] std::set<int32_t> reads(std::span<const int32_t> layers) const {
    return needed(layers).front();
  }
  // Returns how many layers on either side of its own a layer depends on.
  [[nodiscard]] int32_t reach() const;

  // The bricks in `region` of coefficients of `layers`, holes included. samples: all that they read; their
  // bricks outside the region, as far as one beside it, count, and those that are absent are air.
  [[nodiscard]] std::vector<SampleLayer> apply(std::span<const int32_t> layers,
                                               const std::map<int32_t, const SampleLayer*>& samples,
                                               const CoefficientForm& form, const BrickBox& region,
                                               const Context& context) const;
  // The same of one layer, where stages are in space alone. Bricks that nobody else has may be written over.
  [[nodiscard]] SampleLayer apply_to(int32_t layer, BrickLayer samples, const CoefficientForm& form,
                                     const BrickBox& region, const Context& context) const;

 private:
  [[nodiscard]] InversePrefilter inverse() const;
  // The same where the first stage has a pole.
  [[nodiscard]] std::vector<SampleLayer> invert(std::span<const int32_t> layers,
                                                const std::map<int32_t, const SampleLayer*>& samples,
                                                const CoefficientForm& form, const BrickBox& region,
                                                const Context& context) const;
  // The layers of each stage, samples first, that the last one's depend on.
  [[nodiscard]] std::vector<std::set<int32_t>> needed(std::span<const int32_t> layers) const;
  friend class StagePlan;

  Lattice4 lattice_;
  std::vector<PrefilterStep> steps_;
};

} // namespace bccsplat
