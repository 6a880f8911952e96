// SPDX-License-Identifier: Apache-2.0
// The sites of a chunk.
#include "formats/bcc4/coding/chunk.h"

#include <algorithm>

#include "formats/bcc4/coding/chunk_rows.h"

namespace bccsplat {

uint64_t ChunkShape::sites() const {
  uint64_t n = 0;
  for (int m = 0; m < layers; ++m) {
    const auto& [x, y, z] = box[m];
    n += x * y * z;
  }
  return n;
}

ChunkShape chunk_shape(const Lattice4& lattice, int32_t first_layer, int32_t layers, const Int3& brick) {
  ChunkShape shape;
  shape.layers = layers;
  shape.period = lattice.layer_period();
  shape.still = lattice.is_static();
  shape.first_coset = lattice.coset(first_layer);
  for (int m = 0; m < shape.layers; ++m) {
    const Int3 dims = lattice.space.dims(shape.coset(m));
    Int3 n;
    for (size_t a = 0; a < 3; ++a) n[a] = std::clamp(dims[a] - brick[a] * brick_edge, 0, brick_edge);
    if (n[0] > 0 && n[1] > 0 && n[2] > 0) shape.box[m] = n;
  }
  return shape;
}

uint32_t ChunkSites::holes() const {
  int n = 0;
  for (const auto& mask : hole) n += count_bits(mask);
  return n;
}

} // namespace bccsplat
