// SPDX-License-Identifier: Apache-2.0
// A brick of coefficients as whole numbers of 16 bits: half of what values take.
//
// The step is a power of two, so that every value is exact in single precision, and depends on nothing but
// the brick: whoever makes it, alone or with others, rounds alike.
#pragma once

#include <array>
#include <cstdint>

#include "points/sample_layer.h"

namespace bccsplat {

// The coarsest step for coefficients of samples that come in steps of `sample_step`: a quarter of it or less.
// Rounded so the field errs by a thirteenth of what its samples' own rounding gives it, 0.02 dB, at most:
// the kernel passes 0.27 of the noise of coefficients.
[[nodiscard]] float coarsest_step(double sample_step);

class RoundedBrick final : public CodedBrick {
 public:
  // Returns null where the values need coarser steps. coarsest: a power of two.
  [[nodiscard]] static std::shared_ptr<const RoundedBrick> round(const Brick& brick, float coarsest);

  void read(const PlanePart& part, float* to, std::ptrdiff_t stride) const override;
  [[nodiscard]] const BrickMask* kept() const override { return masks_.kept.get(); }
  [[nodiscard]] const BrickMask* hole() const override { return masks_.hole.get(); }
  [[nodiscard]] uint64_t bytes() const override;
  [[nodiscard]] float step() const { return step_; }

 private:
  static constexpr size_t beside = brick_edge; // behind the last row, which may be read from its end on

  alignas(64) std::array<int16_t, brick_sites + beside> number_;
  float step_ = 1;
  BrickMasks masks_;
};

} // namespace bccsplat
