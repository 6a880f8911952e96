// SPDX-License-Identifier: Apache-2.0
#include "store/coefficient_slabs.h"

#include <utility>

namespace bccsplat {

CoefficientSlabs::CoefficientSlabs(const Lattice4& lattice, const VolumeInfo& info, const SeriesPart* part)
    : layers_(lattice.layers()), slab_layers_(info.slab_layers), periodic_(lattice.periodic) {
  CoefficientSpan span{.end = layers_, .slab_layers = slab_layers_};
  if (part) span = {part->fit.first_layer, part->first_layer, part->end_layer, slab_layers_};
  for (const ChannelInfo& c : info.channels)
    channels_.push_back(std::make_unique<Channel>(
        Channel{.maker{lattice, c, c.threshold, info.coefficient_kernel, span}, .slabs = {}}));
}

void CoefficientSlabs::set_lattice(const Lattice4& lattice) {
  layers_ = lattice.layers();
  for (const auto& c : channels_) c->maker.set_lattice(lattice);
}

void CoefficientSlabs::add_layers(int channel, int32_t first, const SlabLayers& samples,
                                  const Context& context, const FitSink& store) {
  Channel& c = *channels_[channel];
  if (!std::exchange(c.begun, true) && periodic_) c.maker.turn_from(first);
  for (const SampleLayer& layer : samples.compact()) {
    c.maker.push(layer, context);
    make(c, context);
    ++first;
  }
  if (first % slab_layers_ == 0 || (periodic_ && first == layers_)) store_made(channel, store);
}

void CoefficientSlabs::finish(int channel, const Context& context, const FitSink& store) {
  make(*channels_[channel], context);
  store_made(channel, store);
}

void CoefficientSlabs::make(Channel& c, const Context& context) const {
  while (auto slab = c.maker.next(context)) c.slabs.push_back(std::move(*slab));
}

void CoefficientSlabs::store_made(int channel, const FitSink& store) {
  for (CoefficientSlab& made : std::exchange(channels_[channel]->slabs, {})) {
    const CoefficientSlab slab = std::move(made); // goes when it is stored
    store(slab.first / slab_layers_, channel, slab.layers);
  }
}

} // namespace bccsplat
