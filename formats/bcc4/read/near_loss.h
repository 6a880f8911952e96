// SPDX-License-Identifier: Apache-2.0
// What is lost beside a lost chunk: the field misses it as far as its kernel reaches. (The coefficients there
// are made of samples that the prefilter found to be air; what it spoils further out is small.)
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "lattice/lattice.h"
#include "points/brick.h"

namespace bccsplat {

class NearLoss {
 public:
  // The field is made with this kernel.
  NearLoss(const std::string& kernel, const Lattice4& lattice);

  // Layers up to this far from a lost one have points that miss it.
  [[nodiscard]] int32_t layers() const { return layers_; }
  // Makes holes of the sites of a layer within reach of layers in which bricks at these positions are lost:
  // of all sites that may be the nearest one to a point that misses a coefficient.
  void mark(std::span<const Int3> lost, BrickLayer& layer) const;

 private:
  int32_t planes_ = 0, layers_ = 0;
};

} // namespace bccsplat
