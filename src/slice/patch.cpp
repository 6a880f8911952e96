#include "slice/patch.h"

#include <algorithm>

namespace bccsplat {

const float* air_brick() {
  alignas(64) static constexpr std::array<float, brick_sites> air{};
  return air.data();
}

void place_mirrored(const BrickLayer& layer, size_t axis, int first, int count, PatchPlace::Axis& out) {
  std::array<int, patch_edge> at;
  for (int i = 0; i < patch_edge; ++i)
    at[static_cast<size_t>(i)] = layer.lattice().mirror(axis, layer.coset(), first + std::min(i, count - 1));
  const auto [low, high] = std::minmax_element(at.begin(), at.end());
  out.low = *low / brick_edge;
  out.bricks = 1 + (*high / brick_edge != out.low);
  for (size_t i = 0; i < patch_edge; ++i) {
    out.half[i] = at[i] / brick_edge != out.low;
    out.site[i] = at[i] % brick_edge;
  }
}

} // namespace bccsplat
