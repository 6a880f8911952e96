// SPDX-License-Identifier: Apache-2.0
// A file that is being written as a series of its own: the layers that are there, and of the frames those
// whose moments depend on no others.
#include <algorithm>

#include "store/channel_info.h"
#include "store/volume_writer.h"

namespace bccsplat {

void VolumeWriter::show_if_due() {
  if (settings_.live_slabs == 0 || !container_) return;
  const int32_t slabs = container_->common_slabs();
  if (slabs - shown_slabs_ < static_cast<int32_t>(std::min<uint32_t>(settings_.live_slabs, INT32_MAX)))
    return;
  const int32_t layers = slabs * initial_.slab_layers;
  const uint32_t frames = frames_to_show(layers);
  if (frames < 2) return; // a lattice without time is another one
  store_masks();
  container_->show(info_to_show(frames, layers), context_);
  shown_slabs_ = slabs;
}

// Returns how many frames depend on the first `layers` layers alone, with the kernel of the file.
uint32_t VolumeWriter::frames_to_show(int32_t layers) const {
  Lattice4 lattice = fit().lattice();
  if (lattice.is_static()) return 0;
  if (settings_.dims[3] == 0) lattice.last_layer = INT32_MAX / 2; // it has no end yet
  const auto is_whole = [&](uint32_t frame) {
    return layers_to_measure(lattice, initial_.recommended_kernel, settings_.coefficients, frame).end <=
           layers;
  };
  const double last = lattice.layer_frame(layers - 1);
  auto frames = last < 0 ? 0 : static_cast<uint32_t>(last) + 1;
  if (input_ == Input::frames)
    frames = std::min(frames, static_cast<uint32_t>(*std::min_element(added_.begin(), added_.end())));
  if (settings_.dims[3] > 0) frames = std::min(frames, settings_.dims[3]);
  while (frames > 0 && !is_whole(frames - 1)) --frames;
  return frames;
}

VolumeInfo VolumeWriter::info_to_show(uint32_t frames, int32_t layers) const {
  VolumeInfo info = container_->info();
  const auto end_there = [&](Lattice4& lattice) {
    lattice.dims[3] = frames, lattice.last_layer = layers - 1;
  };
  end_there(info.lattice);
  info.time = input_ == Input::frames ? time_map(frames) : initial_.time;
  info.sources = initial_.sources, info.attributes = initial_.attributes;
  info.expected_frames = settings_.dims[3];
  const FitReport report = report_of_fits();
  const uint64_t samples = info.cc_samples();
  for (size_t c = 0; c < added_.size(); ++c) {
    ChannelInfo& channel = info.channels[c];
    describe_channel(report.channels[c], channel);
    tell_base(c, channel);
    channel.cc_relevant = std::min(channel.cc_relevant, samples); // of all frames that were given
    if (!channel.frames.empty()) channel.frames.resize(frames);
    for (size_t l = 1; l < fits_.size(); ++l)
      info.levels[l - 1].channels[c].clamped = report.channels[l * added_.size() + c].clamped;
  }
  for (LevelInfo& level : info.levels) end_there(level.lattice);
  return info;
}

} // namespace bccsplat
