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
    : level_(level), slab_layers_(options.slab_layers), store_(std::move(store)), context_(context),
      fit_(
          options,
          [this](int32_t slab, int channel, const SlabLayers& layers) { take_slab(slab, channel, layers); },
          context, std::move(masks)) {}

void LevelFit::store_coefficients(const VolumeInfo& info, const SeriesPart* part) {
  coefficients_ = std::make_unique<CoefficientSlabs>(fit_.lattice(), info, part);
}

void LevelFit::shorten(uint32_t frames, const VolumeInfo& info) {
  fit_.shorten(frames);
  if (coefficients_) coefficients_->set_lattice(fit_.lattice(), info);
}

void LevelFit::take_slab(int32_t slab, int channel, const SlabLayers& layers) {
  if (!coefficients_) return store_(slab, {channel, level_}, layers);
  coefficients_->add_layers(channel, slab * slab_layers_, layers, context_,
                            [this](int32_t made, int of, const SlabLayers& coefficients) {
                              store_(made, {of, level_}, coefficients);
                            });
}

FitChannelReport level_counts(const FitChannelReport& report) {
  FitChannelReport counts;
  counts.clamped = report.clamped, counts.clamped_slabs = report.clamped_slabs;
  counts.lasting.clamped = report.lasting.clamped;
  return counts;
}

} // namespace bccsplat
