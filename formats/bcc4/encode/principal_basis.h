// SPDX-License-Identifier: Apache-2.0
// The basis of time that a slab's own frames ask for.
#pragma once

#include <span>
#include <vector>

#include "formats/bcc4/wavelet/time_basis.h"

namespace bccsplat {

// The means of the products of frames, each with each, from some of their samples. slab: the frames, one
// after the other.
struct FrameProducts {
  FrameProducts(std::span<const float> slab, int frames);
  int frames;
  std::vector<double> means;
};
// The principal components of the frames, the strongest first.
[[nodiscard]] TimeBasis principal_basis(const FrameProducts& products);
// The mean squares of the layers that the frames make.
[[nodiscard]] std::vector<double> variances_in(const TimeBasis& basis, const FrameProducts& products);

} // namespace bccsplat
