// SPDX-License-Identifier: Apache-2.0
// Layers that are handed on together, in the form that whoever made them has; the other form is made for
// those who ask for it.
#pragma once

#include <span>
#include <vector>

#include "points/sample_layer.h"

namespace bccsplat {

// Borrows the layers. What it makes lasts as long as it does.
class SlabLayers {
 public:
  // rounded: the sum of the squares by which their values were rounded to those stored.
  SlabLayers(std::span<const SampleLayer> layers, double rounded = 0) : compact_(layers), rounded_(rounded) {}
  SlabLayers(const std::vector<SampleLayer>& layers) : SlabLayers(std::span(layers)) {}
  SlabLayers(std::span<const BrickLayer> layers) : values_(layers) {}
  SlabLayers(const std::vector<BrickLayer>& layers) : SlabLayers(std::span(layers)) {}
  SlabLayers(const SlabLayers&) = delete;
  SlabLayers& operator=(const SlabLayers&) = delete;

  [[nodiscard]] std::span<const SampleLayer> compact() const;
  [[nodiscard]] std::span<const BrickLayer> values() const;
  operator std::span<const BrickLayer>() const { return values(); }
  [[nodiscard]] double rounded() const { return rounded_; }

 private:
  std::span<const SampleLayer> compact_;
  std::span<const BrickLayer> values_;
  double rounded_ = 0;
  mutable std::vector<SampleLayer> made_compact_;
  mutable std::vector<BrickLayer> made_values_;
};

} // namespace bccsplat
