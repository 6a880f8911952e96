// SPDX-License-Identifier: Apache-2.0
// What follows from the kind of data: one table for every door.
#pragma once

#include <cstdint>
#include <vector>

#include "base/vec.h"
#include "series/data_kind.h"

namespace bccsplat {

// What a first picture shows: the volume, three planes through it, both, or one plane seen from above. Values
// are those of the C ABI.
enum class Layout : uint8_t { volume = 1, planes, both, flat };

struct KindLook {
  // Linear RGB from the first to the last value that is shown, where values have one sign; empty: those that
  // data of no known kind have.
  std::vector<Vec3> colors;
  // Optical depth across what has no edge, and across what has both signs.
  double fog_depth, signed_depth;
  // The share of the values beyond air and noise that is left out above the window: rims of coils, metal.
  double rim;
  Layout layout;
};

[[nodiscard]] const KindLook& kind_look(series::DataKind kind);

} // namespace bccsplat
