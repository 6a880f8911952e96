// SPDX-License-Identifier: Apache-2.0
#include "store/level_fit.h"

#include <cmath>

namespace bccsplat {

FitOptions options_of_level(FitOptions options, int level, const Int3& margins) {
  for (size_t a = 0; a < 3; ++a) options.scales[a] = std::ldexp(options.scales[a], level);
  options.margins = margins;
  return options;
}

LevelFit::LevelFit(int level, const FitOptions& options, Store store, const Context& context, MaskSink masks)
    : level_(level),
      store_([level, store = std::move(store)](int32_t slab, int channel, const SlabLayers& layers) {
        store(slab, {channel, level}, layers);
      }),
      context_(context), fit_(
                             options,
                             [this](int32_t number, int channel, const SlabLayers& layers) {
                               if (coefficients_)
                                 coefficients_->add_layers(channel, number, layers, context_, store_);
                               else
                                 store_(number, channel, layers);
                             },
                             context, std::move(masks)) {}

void LevelFit::store_coefficients(const VolumeInfo& info, const SeriesPart* part) {
  coefficients_ = std::make_unique<CoefficientSlabs>(fit_.lattice(), info, part);
}

void LevelFit::shorten(uint32_t frames) {
  fit_.shorten(frames);
  if (coefficients_) coefficients_->set_lattice(fit_.lattice());
}

void LevelFit::finish_channel(int channel) {
  fit_.finish_channel(channel);
  if (coefficients_) coefficients_->store_ready(channel, context_, store_);
}

FitChannelReport level_counts(const FitChannelReport& report) {
  FitChannelReport counts;
  counts.clamped = report.clamped, counts.clamped_slabs = report.clamped_slabs;
  counts.lasting.clamped = report.lasting.clamped;
  return counts;
}

} // namespace bccsplat
