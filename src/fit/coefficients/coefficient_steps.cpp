// SPDX-License-Identifier: Apache-2.0
#include "fit/coefficients/coefficient_steps.h"

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
      brick->value[row * brick_edge + std::countr_zero(bits)] =
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
  std::vector<SampleLayer> out(layers.begin(), layers.end());
  const SampleLayer* widest = out.data(); // coset 1 may lack the last bricks
  for (const SampleLayer& layer : out)
    if (layer.brick_slots() > widest->brick_slots()) widest = &layer;
  context.tasks.parallel_for(widest->brick_slots(), [&](uint64_t slot) {
    context.progress.check();
    round_chunk(first, out, widest->slot_position(slot));
  });
  return out;
}

void CoefficientSteps::round(int32_t first, std::span<SampleLayer> layers, const BrickBox& box,
                             const Context& context) const {
  for (int z = box.begin[2]; z < box.end[2]; ++z)
    for (int y = box.begin[1]; y < box.end[1]; ++y)
      for (int x = box.begin[0]; x < box.end[0]; ++x) {
        context.progress.check();
        round_chunk(first, layers, {x, y, z});
      }
}

void CoefficientSteps::round_chunk(int32_t first, std::span<SampleLayer> layers, const Int3& at) const {
  std::vector<std::shared_ptr<const Brick>> values(layers.size());
  std::vector<const Brick*> bricks(layers.size());
  bool any = false;
  for (size_t m = 0; m < layers.size(); ++m) {
    const Int3& n = layers[m].brick_dims();
    if (at[0] >= n[0] || at[1] >= n[1] || at[2] >= n[2]) continue;
    values[m] = layers[m].brick(at[0], at[1], at[2]).as_values();
    bricks[m] = values[m].get();
    any |= bricks[m] != nullptr;
  }
  if (!any) return;
  const ChunkShape shape = chunk_shape(lattice_, first, static_cast<int32_t>(layers.size()), at);
  const CoefficientChunk chunk = round_coefficients(shape, bricks, coding_);
  const ChunkData data = packed(chunk);
  const bool narrow = data.coded.bytes() <= 2;
  const uint32_t* next = chunk.sites.codes.data();
  for (size_t m = 0; m < layers.size(); ++m) {
    if (!bricks[m]) continue;
    SampleBrick rounded;
    if (data.first[m] == data.first[m + 1])
      rounded = {};
    else if (narrow)
      rounded.codes = std::make_shared<const LayerCodes>(coder_, data, m);
    else
      rounded.values = brick_of(chunk.sites, m, coding_, next);
    layers[m].set(layers[m].slot(at[0], at[1], at[2]), std::move(rounded));
  }
}

} // namespace bccsplat
