#include "fit/round_layer.h"

#include <algorithm>

#include "fit/relevance.h"

namespace bccsplat {

BrickLayer round_layer(const BrickLayer& layer, const Quantiser& quantiser, float threshold,
                       const Context& context) {
  const Relevance relevance(quantiser, threshold);
  BrickLayer out(layer.lattice(), layer.coset());
  context.tasks.parallel_for(layer.brick_slots(), [&](uint64_t slot) {
    const Brick* brick = layer.brick(slot);
    if (!brick) return;
    const Int3 position = layer.slot_position(slot);
    Int3 size;
    for (size_t a = 0; a < 3; ++a) size[a] = std::min(brick_edge, layer.dims()[a] - position[a] * brick_edge);
    auto made = std::make_shared<Brick>();
    if (relevance.select(brick->value.data(), size, {brick->hole.get(), nullptr, 0}, *made).kept > 0)
      out.set(slot, std::move(made));
  });
  return out;
}

} // namespace bccsplat
