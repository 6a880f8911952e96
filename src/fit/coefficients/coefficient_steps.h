// SPDX-License-Identifier: Apache-2.0
// Rounds slabs of coefficients to whole steps from air, as a file stores them.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "base/context.h"
#include "formats/bcc4/coding/codes.h"
#include "formats/bcc4/encode/coefficient_codes.h"
#include "points/sample_layer.h"
#include "points/sample_source.h"
#include "points/values.h"

namespace bccsplat {

class CoefficientSteps {
 public:
  // steps: of type i32. kernel: of the coefficients.
  CoefficientSteps(const Lattice4& lattice, const Quantiser& steps, const std::string& kernel);

  // Rounds the layers from `first` on, all of one slab; what comes out is stored as it is: codes, where these
  // take two bytes or less, which the container need not find again.
  [[nodiscard]] std::vector<SampleLayer> round(int32_t first, std::span<const BrickLayer> layers,
                                               const Context& context) const;
  // The same of the bricks of a box, in place: each chunk's values go when it has been rounded. Several
  // threads may round boxes that have no brick in common.
  void round(int32_t first, std::span<SampleLayer> layers, const BrickBox& box, const Context& context) const;

 private:
  void round_chunk(int32_t first, std::span<SampleLayer> layers, const Int3& at) const;

  Lattice4 lattice_;
  SampleCoder coder_;
  CoefficientCoding coding_;
};

} // namespace bccsplat
