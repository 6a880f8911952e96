// SPDX-License-Identifier: Apache-2.0
#include "store/level_fit.h"

#include <cmath>

namespace bccsplat {

FitOptions options_of_level(FitOptions options, int level, const Int3& margins) {
  for (size_t a = 0; a < 3; ++a) options.scales[a] = std::ldexp(options.scales[a], level);
  options.margins = margins;
  return options;
}

void LevelFits::begin(const std::vector<FitOptions>& options, const Store& store, const MaskSink& masks,
                      const Context& context) {
  const MaskSink untold = [](int, uint32_t, const std::vector<std::byte>&) {};
  frames_.emplace(options, context);
  for (int l = 0; l < static_cast<int>(options.size()); ++l) {
    const FitSink sink = [l, store](int32_t slab, int channel, const SlabLayers& layers) {
      store(slab, {channel, l}, layers);
    };
    fits_.push_back(std::make_unique<Fit>(options[l], sink, context, l == 0 ? masks : untold));
  }
}

void LevelFits::add_frame(int channel, std::span<const FrameBox> boxes, const FrameScan& scan,
                          float ringing) {
  const PreparedFrame prepared = fit().prepare_frame(channel, boxes, scan);
  if (coarsest() > 0) { // what coarser levels are made of goes before level 0 takes its memory
    const LevelFrames::Images images = frames_->make(prepared, ringing);
    for (int l = coarsest(); l > 0; --l) fits_[l]->add_frame(channel, prepared, images.at(l));
  }
  fit().add_frame(channel, prepared, {prepared.frame, scan.cells, prepared.faces});
}

void LevelFits::describe_lattices(VolumeInfo& info) const {
  info.lattice = lattice();
  for (int l = 1; l <= coarsest(); ++l) info.levels[static_cast<size_t>(l) - 1].lattice = lattice(l);
}

FitReport LevelFits::report() const {
  FitReport result = fit().report();
  for (size_t l = 1; l < fits_.size(); ++l)
    for (const FitChannelReport& r : fits_[l]->report().channels) {
      FitChannelReport& counts = result.channels.emplace_back();
      counts.clamped = r.clamped, counts.clamped_slabs = r.clamped_slabs;
      counts.lasting.clamped = r.lasting.clamped;
    }
  return result;
}

} // namespace bccsplat
