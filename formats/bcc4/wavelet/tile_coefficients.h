// SPDX-License-Identifier: Apache-2.0
// The coefficients of a box as lists of those that are not 0: any sum of its layers is made by one inverse.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "formats/bcc4/wavelet/halvings.h"
#include "formats/bcc4/wavelet/time_basis.h"

namespace bccsplat {

// The coefficients of one layer of a basis of time: a list, or where that would take more, all of them.
class CoefficientList {
 public:
  // Each place is set once.
  void set(size_t at, float value, size_t samples);
  [[nodiscard]] bool empty() const { return values_.empty(); }
  void add_to(std::span<float> sum, float weight) const;
  [[nodiscard]] uint64_t bytes() const {
    return places_.capacity() * sizeof(uint32_t) + values_.capacity() * sizeof(float);
  }

 private:
  std::vector<uint32_t> places_; // empty: values_ has every place
  std::vector<float> values_;
};

class TileCoefficients {
 public:
  TileCoefficients() = default;
  TileCoefficients(const Halvings& shape, TimeBasis basis)
      : shape_(shape), basis_(std::move(basis)), layers_(basis_.frames) {}

  [[nodiscard]] const Halvings& shape() const { return shape_; }
  [[nodiscard]] const TimeBasis& basis() const { return basis_; }
  // layer: one of the basis.
  [[nodiscard]] const CoefficientList& layer(int layer) const { return layers_[layer]; }
  void set(int layer, size_t at, float value) { layers_[layer].set(at, value, shape_.samples()); }
  // Adds the coefficients of the frames, each times its weight, to a sum of shape().samples() values.
  void add_to(std::span<float> sum, std::span<const float> weights) const;
  [[nodiscard]] uint64_t bytes() const;

 private:
  Halvings shape_;
  TimeBasis basis_;
  std::vector<CoefficientList> layers_;
};

} // namespace bccsplat
