// SPDX-License-Identifier: Apache-2.0
#include "store/coefficient_slabs.h"

#include <utility>

namespace bccsplat {

CoefficientSlabs::CoefficientSlabs(const Lattice4& lattice, const VolumeInfo& info, const SeriesPart* part)
    : slab_layers_(info.slab_layers), periodic_(lattice.periodic) {
  CoefficientSpan span{.end = lattice.layers(), .slab_layers = slab_layers_};
  if (part) span = {part->fit.first_layer, part->first_layer, part->end_layer, slab_layers_, part->bricks};
  for (const ChannelInfo& c : info.channels)
    channels_.push_back(
        std::make_unique<Channel>(Channel{.maker{lattice, c, c.threshold, info.coefficient_kernel, span}}));
}

void CoefficientSlabs::set_lattice(const Lattice4& lattice) {
  for (const auto& c : channels_) c->maker.set_lattice(lattice);
}

void CoefficientSlabs::add_layers(int channel, int32_t first, const SlabLayers& samples,
                                  const Context& context, const FitSink& store) {
  Channel& c = *channels_[channel];
  if (!std::exchange(c.begun, true) && periodic_) c.maker.turn_from(first);
  for (const SampleLayer& layer : samples.compact()) {
    c.maker.push(layer, context);
    store_ready(channel, context, store);
  }
}

void CoefficientSlabs::store_ready(int channel, const Context& context, const FitSink& store) {
  while (const auto slab = channels_[channel]->maker.next(context))
    store(slab->first / slab_layers_, channel, slab->layers);
}

} // namespace bccsplat
