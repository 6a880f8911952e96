// SPDX-License-Identifier: Apache-2.0
#include "gpu/gpu_kept.h"

namespace bccsplat {

SliceMark mark_of(const Slice& slice) {
  uint64_t hash = 0;
  for (const BrickLayer& layer : slice.coset)
    for (size_t s = 0; s < layer.brick_slots(); ++s) {
      constexpr uint64_t factor = 0x9e3779b97f4a7c15;
      constexpr int half = 32;
      hash = (hash ^ reinterpret_cast<uintptr_t>(layer.brick(s))) * factor;
      hash ^= hash >> half;
    }
  SliceMark mark = mark_without_bricks(slice);
  mark.bricks = hash;
  return mark;
}

SliceMark mark_without_bricks(const Slice& slice) {
  return {&slice,      0, slice.corrections.get(), slice.mask.get(), slice.frame, slice.milliseconds,
          slice.bounds};
}

GpuClassKey key_of(const Shot& shot, const ClassTable& table, const std::vector<Vec4f>& texels) {
  return {shot.options.mode,
          texels,
          table.low,
          table.scale,
          shot.options.surfaces,
          shot.options.disable_skips,
          cells_of_step(shot),
          shot.slice->base,
          shot.slice->air};
}

} // namespace bccsplat
