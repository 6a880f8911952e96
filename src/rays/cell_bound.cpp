// SPDX-License-Identifier: Apache-2.0
#include "rays/cell_bound.h"

#include <string_view>

namespace bccsplat {
namespace {

struct Proven {
  std::string_view shape;
  CellBound bound, refined;
};
// What the proof (tests/support/cell_bound_proof.h) finds for eighths and 4^3 parts of a cell, rounded up.
constexpr Proven proven[] = {{"radial16", {0.1284, 0.0127}, {0.0379, 0.0077}},
                             {"radial18", {0.0939, 0.0080}, {0.0264, 0.0040}},
                             {"radial20", {0.0838, 0.0032}, {0.0228, 0.0024}}};

} // namespace

std::optional<CellBound> cell_bound(const Kernel& kernel, int parts) {
  const std::string_view shape = std::string_view(kernel.name).substr(0, kernel.name.find('+'));
  for (const Proven& p : proven)
    if (p.shape == shape) return parts == refined_parts ? p.refined : p.bound;
  return std::nullopt;
}

} // namespace bccsplat
