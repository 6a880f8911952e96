// SPDX-License-Identifier: Apache-2.0
#include "points/sample_source.h"

namespace bccsplat {

void SampleSource::read_layers(int channel, std::span<const int32_t> layers, const BrickBox& region,
                               const Context& context, const TakeLayer<BrickLayer>& take) const {
  for (const int32_t m : layers) take(m, read_layer(channel, m, region, context));
}

void SampleSource::read_samples(int channel, std::span<const int32_t> layers, const BrickBox& region,
                                const Context& context, const TakeLayer<SampleLayer>& take) const {
  for (const int32_t m : layers) take(m, SampleLayer(read_layer(channel, m, region, context)));
}

} // namespace bccsplat
