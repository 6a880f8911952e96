// SPDX-License-Identifier: Apache-2.0
#include "fit/coefficients/round_layer.h"

#include <algorithm>
#include <atomic>

#include "fit/kept/relevance.h"

namespace bccsplat {

BrickLayer round_layer(const BrickLayer& layer, const Quantiser& quantiser, float threshold,
                       uint64_t& clamped, const Context& context) {
  const Relevance relevance(quantiser, threshold);
  BrickLayer out(layer.lattice(), layer.coset());
  std::atomic<uint64_t> over{0};
  context.tasks.parallel_for(layer.brick_slots(), [&](uint64_t slot) {
    context.progress.check();
    const Brick* brick = layer.brick(slot);
    if (!brick) return;
    const Int3 position = layer.slot_position(slot);
    Int3 size;
    for (size_t a = 0; a < 3; ++a) size[a] = std::min(brick_edge, layer.dims()[a] - position[a] * brick_edge);
    auto made = std::make_shared<Brick>();
    const KeptCounts counts =
        relevance.select(brick->value.data(), size, {brick->hole.get(), nullptr, 0}, *made);
    over.fetch_add(counts.clamped, std::memory_order_relaxed);
    if (counts.kept > 0) out.set(slot, std::move(made));
  });
  clamped += over;
  return out;
}

} // namespace bccsplat
