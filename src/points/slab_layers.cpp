// SPDX-License-Identifier: Apache-2.0
#include "points/slab_layers.h"

namespace bccsplat {

std::span<const SampleLayer> SlabLayers::compact() const {
  if (values_.empty()) return compact_;
  if (made_compact_.empty())
    for (const BrickLayer& layer : values_) made_compact_.emplace_back(layer);
  return made_compact_;
}

std::span<const BrickLayer> SlabLayers::values() const {
  if (compact_.empty()) return values_;
  if (made_values_.empty())
    for (const SampleLayer& layer : compact_) made_values_.push_back(layer.as_values());
  return made_values_;
}

} // namespace bccsplat
