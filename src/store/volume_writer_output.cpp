// SPDX-License-Identifier: Apache-2.0
// The way of slabs from the fit into the file.
#include "formats/bcc4/write/journal.h"
#include "store/fingerprint.h"
#include "store/volume_writer.h"

namespace bccsplat {
namespace {

// Returns what layers have in a box.
std::vector<SampleLayer> bricks_in(const BrickBox& box, std::span<const SampleLayer> layers) {
  std::vector<SampleLayer> in;
  for (const SampleLayer& layer : layers) {
    SampleLayer& to = in.emplace_back(layer.lattice(), layer.coset());
    for (size_t slot = 0; slot < layer.brick_slots(); ++slot)
      if (box.contains(layer.slot_position(slot))) to.set(slot, layer.share(slot));
  }
  return in;
}

} // namespace

// A block whose samples are compared is made with bricks of others beside its own.
void VolumeWriter::store_slab(int32_t slab, const ChannelLevel& at, const SlabLayers& layers) {
  now_.slab = slab, now_.channel = at.channel, now_.level = at.level;
  const double rounded = at.level == 0 ? layers.rounded() : 0; // what is promised is of level 0
  if (!part_ || (slab >= part_->first_slab && slab < part_->end_slab)) {
    make_container();
    store_masks();
    if (is_block() && at.level == 0)
      container_->write_slab(slab, at, bricks_in(part_->fit.bricks.counted, layers.compact()), context_);
    else
      container_->write_slab(slab, at, layers.compact(), context_, rounded);
    if (part_) writes_.push_back(now_);
  }
  measuring_.with_level(at.level, [&](RoundTrip& r) {
    const int32_t first = slab * fit_options_.slab_layers;
    if (!settings_.wavelets) return r.add_layers(at.channel, first, layers);
    make_container();
    const std::span<const SampleLayer> given = layers.compact();
    r.add_layers(at.channel, first, container_->as_read(slab, at, given, context_, rounded), given);
  });
}

void VolumeWriter::store_residuals(int channel, uint32_t frame, const FrameResiduals& residuals) {
  make_container();
  store_masks();
  container_->write_residuals(channel, frame, residuals, context_);
  if (!part_) return;
  writes_.push_back(now_);
  writes_.back().frame = frame, writes_.back().level = 0;
}

// Frames that are given to a part for the sake of its slabs alone are those of another one.
void VolumeWriter::take_mask(int channel, uint32_t frame, std::vector<std::byte> runs) {
  if (part_ && !part_->fit.counted.has_frame(frame)) return;
  masks_.push_back({channel, frame, std::move(runs)});
}

void VolumeWriter::store_masks() {
  for (const WaitingMask& m : masks_) {
    if (continued_ && continued_->has_mask(m.frame, m.channel)) continue;
    container_->write_mask(m.channel, m.frame, m.runs, context_);
    if (part_) writes_.push_back({m.frame, static_cast<uint32_t>(m.channel), PartWrite::mask, m.frame});
  }
  masks_.clear();
}

// The container is made as late as it can be: what the host says before that is in its first records.
void VolumeWriter::make_container() {
  if (container_) return;
  VolumeInfo info = initial_;
  info.lattice = fit().lattice();
  // A series that ended sooner than was said may have another lattice at every level.
  for (const auto& f : fits_)
    if (f->level() > 0) info.levels[static_cast<size_t>(f->level()) - 1].lattice = f->fit().lattice();
  const Bcc4WriterOptions options = container_options(info);
  container_ = std::make_unique<Bcc4Writer>(std::move(sink_), info, options);
  if (continued_) continued_->copy_what_stays(*container_, context_.progress);
}

Bcc4WriterOptions VolumeWriter::container_options(const VolumeInfo& info) const {
  Bcc4WriterOptions options;
  if (continued_) {
    require_continuable(continued_->info(), info, settings_.dims[3], settings_.path);
  } else if (settings_.continuity == Continuity::append) {
    // All frames come again; the slabs that new ones leave as they are need not be coded.
    options.earlier = Bcc4Reader::open(open_file_source(settings_.path));
    const VolumeInfo& was = options.earlier->info();
    require_continuable(was, info, settings_.dims[3], settings_.path);
    options.earlier_slabs = lasting_slabs(was.lattice, fit_options_, layer_use(), was.lattice.dims[3]);
  } else if (settings_.continuity != Continuity::none) {
    options.journal =
        std::make_shared<Bcc4Journal>(settings_.path, settings_.continuity == Continuity::resume,
                                      Bcc4Journal::default_interval, journal_options_);
    options.fingerprint = writer_checksum();
  }
  return options;
}

uint32_t VolumeWriter::settings_checksum(std::optional<double> psnr) const {
  return options_checksum(fit_options_, settings_.levels, bounds_text(settings_), psnr);
}

uint32_t VolumeWriter::writer_checksum() const {
  if (part_) return part_checksum(settings_checksum(settings_.psnr), part_->fit);
  return settings_checksum({}) ^ settings_.live_slabs; // which sets offsets
}

} // namespace bccsplat
