// SPDX-License-Identifier: Apache-2.0
#include "points/sample_source.h"

#include "base/error.h"

namespace bccsplat {

BrickBox bricks_on(const Lattice3& lattice, const PlaneRange& planes) {
  BrickBox box;
  if (planes.first < 0 || planes.last > lattice.last[planes.axis]) return box;
  const int planes_per_brick = brick_edge * lattice.cosets();
  box.begin[planes.axis] = planes.first / planes_per_brick;
  box.end[planes.axis] = planes.last / planes_per_brick + 1;
  return box;
}

void SampleSource::read_layers(int channel, std::span<const int32_t> layers, const BrickBox& region,
                               const Context& context, const TakeLayer<BrickLayer>& take) const {
  for (const int32_t m : layers) take(m, read_layer(channel, m, region, context));
}

void SampleSource::read_samples(int channel, std::span<const int32_t> layers, const BrickBox& region,
                                const Context& context, const TakeLayer<SampleLayer>& take) const {
  for (const int32_t m : layers) take(m, SampleLayer(read_layer(channel, m, region, context)));
}

std::vector<BrickLayer> SampleSource::add_layers(int, std::span<const LayerSum>, const BrickBox&,
                                                 const Context&) const {
  fail(Code::unsupported, "samples: sums of layers");
}

void SampleSource::list_reads(std::span<const int32_t> layers, const BrickBox& region,
                              LayerReads& out) const {
  for (const int32_t m : layers) out.insert({m, region});
}

} // namespace bccsplat
