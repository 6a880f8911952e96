// SPDX-License-Identifier: Apache-2.0
// What a ray through a slice meets.
#pragma once

#include <cstdint>
#include <optional>

#include "base/context.h"
#include "shade/transfer_function.h"
#include "volume/open_slice.h"

namespace bccsplat {

// value: the first place where the field passes the threshold, from either side; maximum: the largest value;
// opacity: where that of the matter along the ray reaches the threshold, by the function.
enum class PickKind : uint8_t { value = 1, maximum = 2, opacity = 3 };

struct PickRay {
  PickKind kind = PickKind::value;
  Vec3 origin{}, direction{}; // of the world; the direction has unit length
  double begin = 0;           // world distances from the origin that it looks between
  std::optional<double> end;  // none: to the end of the domain
  double threshold = 0;
  const TransferFunction* function = nullptr; // of kind opacity
};

struct PickHit {
  double distance = 0;   // world
  Vec3 world{}, place{}; // place: of slice space
  double value = 0;
  Vec3 gradient{}; // per world unit
};

// Returns what the ray meets inside the slice; none: nothing. Holes are passed over. Places are exact to
// 1/32768 of a sample's distance; what is thinner than an eighth of that distance may be missed.
[[nodiscard]] std::optional<PickHit> pick(const OpenSlice& slice, const PickRay& ray, const Context& context);

} // namespace bccsplat
