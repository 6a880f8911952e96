// SPDX-License-Identifier: Apache-2.0
#include "fit/coefficient_steps.h"

#include <bit>

#include "formats/bcc4/coding/layer_codes.h"
#include "kernel/kernel.h"

namespace bccsplat {
namespace {

// The brick of layer m of a rounded chunk. next: the first of its codes.
std::shared_ptr<const Brick> brick_of(const ChunkSites& sites, size_t m, const CoefficientCoding& coding,
                                      const uint32_t*& next) {
  const BrickMask& kept = sites.kept[m];
  auto brick = std::make_shared<Brick>();
  brick->kept = kept;
  for (size_t row = 0; row < kept.size(); ++row)
    for (unsigned bits = kept[row]; bits; bits &= bits - 1)
      brick->value[row * brick_edge + static_cast<size_t>(std::countr_zero(bits))] =
          static_cast<float>(coefficient_of(*next++, coding));
  if (!sites.hole.empty() && sites.hole[m] != BrickMask{})
    brick->hole = std::make_unique<BrickMask>(sites.hole[m]);
  return brick;
}

// Errors of a coefficient come into the field through the kernel, which on D4* passes a fifth of them (RMS,
// shaped) and on the other lattices two fifths. So steps of four, or of two, times those of samples keep the
// field as right as samples do (tests/bench/notes/coefficient-codes.md).
int most_shift(const Lattice4& lattice) { return lattice.kind == LatticeKind::d4star ? 2 : 1; }

} // namespace

CoefficientSteps::CoefficientSteps(const Lattice4& lattice, const Quantiser& steps, const std::string& kernel)
    : lattice_(lattice), coder_(steps) {
  coding_.step = steps.scale;
  coding_.most_shift = most_shift(lattice);
  if (lattice.space.bcc) coding_.shape = noise_shape(make_kernel(kernel), lattice.is_static());
}

std::vector<SampleLayer> CoefficientSteps::round(int32_t first, std::span<const BrickLayer> layers,
                                                 const Context& context) const {
  std::vector<SampleLayer> out;
  const BrickLayer* widest = layers.data(); // coset 1 may lack the last bricks
  for (const BrickLayer& layer : layers) {
    out.emplace_back(layer.lattice(), layer.coset());
    if (layer.brick_slots() > widest->brick_slots()) widest = &layer;
  }
  context.tasks.parallel_for(widest->brick_slots(), [&](uint64_t slot) {
    context.progress.check();
    const Int3 b = widest->slot_position(slot);
    std::vector<const Brick*> bricks;
    bool any = false;
    const auto inside = [&](const BrickLayer& layer) {
      const Int3& n = layer.brick_dims();
      return b[0] < n[0] && b[1] < n[1] && b[2] < n[2];
    };
    for (const BrickLayer& layer : layers) {
      bricks.push_back(inside(layer) ? layer.brick(b[0], b[1], b[2]) : nullptr);
      any |= bricks.back() != nullptr;
    }
    if (!any) return;
    const ChunkShape shape = chunk_shape(lattice_, first, static_cast<int32_t>(layers.size()), b);
    const CoefficientChunk chunk = round_coefficients(shape, bricks, coding_);
    const ChunkData data = packed(chunk);
    const bool narrow = data.coded.bytes() <= 2;
    const uint32_t* next = chunk.sites.codes.data();
    for (size_t m = 0; m < layers.size(); ++m) {
      if (data.first[m] == data.first[m + 1]) continue;
      const size_t at = out[m].slot(b[0], b[1], b[2]);
      if (narrow)
        out[m].set(at, {nullptr, std::make_shared<const LayerCodes>(coder_, data, m)});
      else
        out[m].set(at, {brick_of(chunk.sites, m, coding_, next), nullptr});
    }
  });
  return out;
}

} // namespace bccsplat
