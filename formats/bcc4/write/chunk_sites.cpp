// SPDX-License-Identifier: Apache-2.0
#include "formats/bcc4/write/chunk_sites.h"

#include <bit>
#include <cmath>

#include "base/error.h"
#include "formats/bcc4/coding/layer_codes.h"

namespace bccsplat {

namespace {

const SampleBrick no_brick;

// The codes of a brick where they are those that are stored; null: there are none, or they may differ.
[[nodiscard]] const LayerCodes* stored_codes(const SampleBrick& brick, const SampleCoder& coder) {
  const auto* codes = dynamic_cast<const LayerCodes*>(brick.codes.get());
  return codes && codes->coded_as(coder) ? codes : nullptr;
}

// Adds the sites of one layer to a chunk.
void collect_layer(ChunkSites& sites, size_t m, const Brick& brick, const Int3& position,
                   const SampleCoder& coder, uint64_t& clamped) {
  const Int3& n = sites.shape.box[m];
  const auto inside = static_cast<uint16_t>((1u << n[0]) - 1);
  for (int z = 0; z < n[2]; ++z)
    for (int y = 0; y < n[1]; ++y) {
      const size_t row = z * brick_edge + y;
      const unsigned hole = brick.hole ? (*brick.hole)[row] & inside : 0u;
      const unsigned kept = (brick.kept[row] | hole) & inside;
      sites.kept[m][row] = static_cast<uint16_t>(kept);
      if (hole) {
        sites.hole.resize(sites.kept.size());
        sites.hole[m][row] = static_cast<uint16_t>(hole);
      }
      for (unsigned bits = kept; bits; bits &= bits - 1) {
        const size_t x = std::countr_zero(bits);
        const float v = brick.value[row * brick_edge + x];
        if (!std::isfinite(v))
          fail(Code::nonfinite_value, "writer: sample at site (",
               position[0] * brick_edge + static_cast<int>(x), ", ", position[1] * brick_edge + y, ", ",
               position[2] * brick_edge + z, ") of layer ", m, " of the slab is not finite");
        sites.codes.push_back(coder.encode(v, clamped));
      }
    }
}

// The same of a layer that is codes, all of whose sites are inside the domain.
void collect_codes(ChunkSites& sites, size_t m, const LayerCodes& codes) {
  if (const BrickMask* kept = codes.kept())
    sites.kept[m] = *kept;
  else
    sites.kept[m].fill(0xffff);
  if (const BrickMask* hole = codes.hole(); hole && *hole != BrickMask{}) {
    sites.hole.resize(sites.kept.size());
    sites.hole[m] = *hole;
  }
  codes.append_codes(sites.codes);
}

} // namespace

const SampleBrick& brick_at(const SampleLayer& layer, const Int3& b) {
  const Int3& n = layer.brick_dims();
  return b[0] < n[0] && b[1] < n[1] && b[2] < n[2] ? layer.brick(b[0], b[1], b[2]) : no_brick;
}

ChunkSites collect_sites(const ChunkShape& shape, std::span<const SampleLayer> layers, const Int3& position,
                         const SampleCoder& coder, uint64_t& clamped) {
  ChunkSites sites;
  sites.shape = shape;
  sites.kept.assign(layers.size(), BrickMask{});
  for (size_t m = 0; m < layers.size(); ++m) {
    const SampleBrick& brick = brick_at(layers[m], position);
    if (!brick) continue;
    if (const LayerCodes* codes = stored_codes(brick, coder))
      collect_codes(sites, m, *codes);
    else
      collect_layer(sites, m, *brick.as_values(), position, coder, clamped);
    if (m == 0) sites.codes.reserve(sites.codes.size() * layers.size());
  }
  return sites;
}

} // namespace bccsplat
