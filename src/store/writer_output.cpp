// SPDX-License-Identifier: Apache-2.0
// Makes the container as late as it can, brings slabs, masks and corrections into it in order, and says what
// a file tells of an unfinished series, or of a finished one.
#include "store/writer_output.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "formats/bcc4/write/journal.h"
#include "store/channel_info.h"

namespace bccsplat {
namespace {

Partial partial_of(Continuity continuity) {
  switch (continuity) {
  case Continuity::journal:
    return Partial::kept;
  case Continuity::resume:
    return Partial::taken_over;
  case Continuity::none:
  case Continuity::append:
    break;
  }
  return Partial::removed;
}

// Begins the file; the journal of an old one that is begun anew goes.
std::unique_ptr<ByteSink> create_sink(const WriterSettings& s) {
  auto sink =
      create_file_sink(s.path, s.overwrite || s.continuity == Continuity::append, partial_of(s.continuity));
  const std::string journal = s.path + ".journal";
  if (!s.keeps_journal() && file_exists(journal)) create_journal_sink(journal, 0)->commit();
  return sink;
}

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

// Times of frames, in the short form where they are evenly spaced.
TimeMap time_map(std::span<const double> times, const std::string& unit) {
  const auto frames = static_cast<double>(times.size());
  TimeMap map{.uniform = true, .first = times.front(), .step = 1, .times = {}, .unit = unit, .epoch = {}};
  if (times.size() > 1) map.step = (times.back() - times.front()) / (frames - 1);
  for (size_t i = 0; i < times.size() && map.uniform; ++i)
    map.uniform = std::fabs(times[i] - map.at(i)) <= 1e-9 * map.step;
  if (!map.uniform) map.times.assign(times.begin(), times.end());
  return map;
}

} // namespace

WriterOutput::WriterOutput(const WriterOpening& opening, const LevelFits& fits, Measuring& measuring,
                           std::unique_ptr<ByteSink> stream, const Context& context)
    : opening_(opening), fits_(fits), measuring_(measuring),
      sink_(stream ? std::move(stream) : create_sink(opening.settings())), context_(context) {}

// A block whose samples are compared is made with bricks of others beside its own.
void WriterOutput::store_slab(int32_t slab, const ChannelLevel& at, const SlabLayers& layers) {
  const SeriesPart* const part = opening_.part();
  now_.slab = slab, now_.channel = at.channel, now_.level = at.level;
  const double rounded = at.level == 0 ? layers.rounded() : 0; // what is promised is of level 0
  if (!part || (slab >= part->first_slab && slab < part->end_slab)) {
    make_container();
    store_masks();
    if (opening_.is_block() && at.level == 0)
      container_->write_slab(slab, at, bricks_in(part->fit.bricks.counted, layers.compact()), context_);
    else
      container_->write_slab(slab, at, layers.compact(), context_, rounded);
    if (part) writes_.push_back(now_);
  }
  measuring_.with_level(at.level, [&](RoundTrip& r) {
    const int32_t first = slab * opening_.fit().slab_layers;
    if (!opening_.settings().wavelets) return r.add_layers(at.channel, first, layers);
    make_container();
    const std::span<const SampleLayer> given = layers.compact();
    r.add_layers(at.channel, first, container_->as_read(slab, at, given, context_, rounded), given);
  });
}

void WriterOutput::store_residuals(int channel, uint32_t frame, const FrameResiduals& residuals) {
  end();
  container_->write_residuals(channel, frame, residuals, context_);
  if (!opening_.part()) return;
  writes_.push_back(now_);
  writes_.back().frame = frame, writes_.back().level = 0;
}

// Frames that are given to a part for the sake of its slabs alone are those of another one.
void WriterOutput::take_mask(int channel, uint32_t frame, std::vector<std::byte> runs) {
  if (opening_.part() && !opening_.part()->fit.counted.has_frame(frame)) return;
  masks_.push_back({channel, frame, std::move(runs)});
}

void WriterOutput::store_masks() {
  for (const WaitingMask& m : masks_) {
    if (opening_.continued() && opening_.continued()->has_mask(m.frame, m.channel)) continue;
    container_->write_mask(m.channel, m.frame, m.runs, context_);
    if (opening_.part())
      writes_.push_back({m.frame, static_cast<uint32_t>(m.channel), PartWrite::mask, m.frame});
  }
  masks_.clear();
}

// The container is made as late as it can be: what the host says before that is in its first records. A
// series that ended sooner than was said may have other lattices by then.
void WriterOutput::make_container() {
  if (container_) return;
  VolumeInfo info = opening_.info();
  fits_.describe_lattices(info);
  const Bcc4WriterOptions options = container_options(info);
  container_ = std::make_unique<Bcc4Writer>(std::move(sink_), info, options);
  if (opening_.continued()) opening_.continued()->copy_what_stays(*container_, context_.progress);
}

Bcc4WriterOptions WriterOutput::container_options(const VolumeInfo& info) const {
  const WriterSettings& s = opening_.settings();
  Bcc4WriterOptions options;
  if (opening_.old()) {
    const VolumeInfo& was = opening_.old()->info();
    require_continuable(was, info, opening_.frames(), s.path);
    if (opening_.continued()) return options;
    // All frames come again; the slabs that new ones leave as they are need not be coded.
    options.earlier = opening_.old();
    options.earlier_slabs = opening_.lasting_slabs(was.lattice);
  } else if (s.keeps_journal()) {
    options.journal =
        std::make_shared<Bcc4Journal>(s.path, s.continuity == Continuity::resume,
                                      Bcc4Journal::default_interval, opening_.journal_options());
    options.fingerprint = opening_.writer_checksum();
  }
  return options;
}

void WriterOutput::end() {
  make_container();
  store_masks();
}

void WriterOutput::show_if_due(const GivenData& given) {
  const uint32_t every = opening_.settings().live_slabs;
  if (every == 0 || !container_) return;
  const int32_t slabs = container_->common_slabs();
  if (slabs - shown_slabs_ < static_cast<int32_t>(std::min<uint32_t>(every, INT32_MAX))) return;
  const int32_t layers = slabs * opening_.info().slab_layers;
  const uint32_t frames = frames_to_show(given, layers);
  if (frames < 2) return; // a lattice without time is another one
  store_masks();
  container_->show(info_to_show(given, frames, layers), context_);
  shown_slabs_ = slabs;
}

uint32_t WriterOutput::frames_to_show(const GivenData& given, int32_t layers) const {
  Lattice4 lattice = fits_.lattice();
  if (lattice.is_static()) return 0;
  if (opening_.frames() == 0) lattice.last_layer = INT32_MAX / 2; // it has no end yet
  const auto is_whole = [&](uint32_t frame) {
    return layers_to_measure(lattice, opening_.info().recommended_kernel, frame).end <= layers;
  };
  const double last = lattice.layer_frame(layers - 1);
  auto frames = last < 0 ? 0 : static_cast<uint32_t>(last) + 1;
  if (given.has_frames()) frames = std::min(frames, static_cast<uint32_t>(given.least()));
  if (opening_.frames() > 0) frames = std::min(frames, opening_.frames());
  while (frames > 0 && !is_whole(frames - 1)) --frames;
  return frames;
}

VolumeInfo WriterOutput::info_to_show(const GivenData& given, uint32_t frames, int32_t layers) const {
  VolumeInfo info = container_->info();
  const auto end_there = [&](Lattice4& lattice) {
    lattice.dims[3] = frames, lattice.last_layer = layers - 1;
  };
  end_there(info.lattice);
  for (LevelInfo& level : info.levels) end_there(level.lattice);
  info.expected_frames = opening_.frames();
  describe(given, frames, fits_.report(), info);
  for (ChannelInfo& channel : info.channels) {
    channel.cc_relevant = std::min(channel.cc_relevant, info.cc_samples()); // of all frames that were given
    if (!channel.frames.empty()) channel.frames.resize(frames);
  }
  return info;
}

void WriterOutput::describe(const GivenData& given, uint32_t frames, const FitReport& report,
                            VolumeInfo& info) const {
  const VolumeInfo& said = opening_.info();
  info.time = given.has_frames() ? time_map(std::span(given.times).first(frames), info.time.unit) : said.time;
  info.sources = said.sources, info.attributes = said.attributes;
  const size_t channels = info.channels.size();
  for (size_t c = 0; c < channels; ++c) {
    describe_channel(report.channels[c], info.channels[c]);
    if (const RoundTrip* const r = measuring_.round_trip()) // the base of a field with corrections
      info.channels[c].residuals.base = r->base(static_cast<int>(c));
    for (size_t l = 0; l < info.levels.size(); ++l)
      info.levels[l].channels[c].clamped = report.channels[(l + 1) * channels + c].clamped;
  }
}

} // namespace bccsplat
