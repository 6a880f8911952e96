// SPDX-License-Identifier: Apache-2.0
#include "store/coefficient_slabs.h"

#include <utility>

namespace bccsplat {

CoefficientSlabs::CoefficientSlabs(const Lattice4& lattice, const VolumeInfo& info, const SeriesPart* part)
    : layers_(lattice.layers()), slab_layers_(info.slab_layers), periodic_(lattice.periodic) {
  const int32_t samples = part ? part->fit.first_layer : 0, first = part ? part->first_layer : 0,
                end = part ? part->end_layer : layers_;
  for (const ChannelInfo& c : info.channels) {
    channels_.push_back(std::make_unique<Channel>(first / slab_layers_, lattice, c, c.threshold,
                                                  info.coefficient_kernel, samples, first, end));
    if (c.type == ValueType::i32) channels_.back()->steps.emplace(lattice, c, info.coefficient_kernel);
  }
}

void CoefficientSlabs::set_lattice(const Lattice4& lattice, const VolumeInfo& info) {
  layers_ = lattice.layers();
  for (size_t c = 0; c < channels_.size(); ++c) {
    channels_[c]->maker.set_lattice(lattice);
    if (channels_[c]->steps) channels_[c]->steps.emplace(lattice, info.channels[c], info.coefficient_kernel);
  }
}

void CoefficientSlabs::add_layers(int channel, int32_t first, const SlabLayers& samples,
                                  const Context& context, const FitSink& store) {
  Channel& c = *channels_[static_cast<size_t>(channel)];
  if (!c.begun && periodic_) c.next_slab = c.maker.turn_from(first, slab_layers_) / slab_layers_;
  c.begun = true;
  for (BrickLayer& layer : c.maker.add(samples.compact(), context)) {
    c.slab.push_back(std::move(layer));
    const auto count = static_cast<int32_t>(c.slab.size());
    if (count < slab_layers_ && c.next_slab * slab_layers_ + count < layers_) continue;
    const int32_t number = c.next_slab++;
    if (c.steps) {
      const auto rounded = c.steps->round(number * slab_layers_, std::exchange(c.slab, {}), context);
      store(number, channel, rounded);
    } else {
      store(number, channel, c.slab);
      c.slab.clear();
    }
    if (periodic_ && c.next_slab * slab_layers_ >= layers_) c.next_slab = 0;
  }
}

} // namespace bccsplat
