// SPDX-License-Identifier: Apache-2.0
// Chunks made of functions of place and time.
#pragma once

#include "formats/bcc4/page.h"
#include "tests/unit/formats/test_data.h"

namespace bccsplat {

// A chunk of a lattice; value(position, frame) gives codes, kept(...) the sites.
template<class Value, class Kept>
ChunkSites make_sites(const VolumeInfo& info, int32_t slab, const Int3& brick, const Value& value,
                      const Kept& kept) {
  ChunkSites sites;
  sites.shape = chunk_shape(info, slab, brick);
  sites.kept.resize(sites.shape.layers);
  for (int m = 0; m < sites.shape.layers; ++m) {
    const Int3 n = sites.shape.box[m];
    for (int z = 0; z < n[2]; ++z)
      for (int y = 0; y < n[1]; ++y)
        for (int x = 0; x < n[0]; ++x) {
          const Vec3 p = info.lattice.site_position(
              sites.shape.coset(m), {brick[0] * 16 + x, brick[1] * 16 + y, brick[2] * 16 + z});
          const double t = info.lattice.layer_frame(slab * info.slab_layers + m);
          if (!kept(p, t)) continue;
          auto& row = sites.kept[m][z * 16 + y];
          row = static_cast<uint16_t>(row | 1u << x);
          sites.codes.push_back(value(p, t));
        }
  }
  return sites;
}

// A full chunk in the midst of a D4* lattice.
template<class Value> ChunkSites full_sites(ValueType type, int32_t slab, const Value& value) {
  return make_sites(test::volume(LatticeKind::d4star, {40, 40, 40, 20}, {test::channel("a", type)}), slab,
                    {0, 0, 0}, value, [](const Vec3&, double) { return true; });
}

inline ChunkCodes codes_of(ValueType type, uint32_t air) {
  ChunkCodes codes;
  codes.type = type, codes.air = air;
  return codes;
}

} // namespace bccsplat
