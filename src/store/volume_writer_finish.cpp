// SPDX-License-Identifier: Apache-2.0
// How a series ends: with the frames that were said or with fewer, and what is then written about it.
#include <algorithm>
#include <cmath>

#include "store/air_warning.h"
#include "store/channel_info.h"
#include "store/fingerprint.h"
#include "store/gap_warning.h"
#include "store/part_report.h"
#include "store/volume_writer.h"

namespace bccsplat {

// Whether the series is complete.
void VolumeWriter::check_end() const {
  if (fits_.empty()) fail(Code::wrong_state, "writer: nothing was added");
  for (const auto& level : fits_) level->fit().check_end();
  check_times(settings_.dims[3]);
  if (settings_.dims[3] == 0) require_no_fewer(added_.front());
}

// A series that goes on does not lose frames of the file.
void VolumeWriter::require_no_fewer(uint64_t frames) const {
  if (settings_.continuity != Continuity::append) return;
  const uint32_t was = Bcc4Reader::open(open_file_source(settings_.path))->info().lattice.dims[3];
  if (frames < was)
    fail(Code::wrong_state, settings_.path, ": it has ", was, " frames already, ", frames, " were given");
}

void VolumeWriter::check_times(uint32_t frames) const {
  if (input_ != Input::layers || frames < 2) return;
  const auto rises = [&](double frame) {
    const double first = initial_.time.first, step = initial_.time.step;
    return first + frame * step > first + (frame - 1) * step;
  };
  if (!rises(1) || !rises(frames - 1.0))
    fail(Code::wrong_state, "times: they do not rise from frame to frame; step is lost beside first");
}

// The frames of a series that ends with what every channel has been given.
uint32_t VolumeWriter::frames_of_short() const {
  if (fits_.empty()) fail(Code::wrong_state, "writer: nothing was added");
  const uint64_t given = added_.front();
  for (size_t c = 0; c < added_.size(); ++c)
    if (added_[c] != given)
      fail(Code::wrong_state, "writer: channel ", c, " was given ", added_[c], ", channel 0 ", given);
  if (input_ == Input::frames) return static_cast<uint32_t>(given);
  // Layers reach as far as the last one stands, but for those beyond the end.
  const Lattice4& lattice = fit().lattice();
  const double last = std::floor(lattice.layer_frame(static_cast<int32_t>(given) - 1 - lattice.lead) + 1e-9);
  if (last < 0) fail(Code::wrong_state, "writer: the layers end before the first frame");
  return static_cast<uint32_t>(std::min(last, lattice.last_frame())) + 1;
}

void VolumeWriter::shorten(uint32_t frames) {
  for (const auto& level : fits_) level->shorten(frames);
  settings_.dims[3] = fit_options_.dims[3] = frames;
  initial_.lattice = fit().lattice();
  for (const auto& level : fits_)
    measuring_.with_level(level->level(), [&](RoundTrip& r) { r.set_lattice(level->fit().lattice()); });
}

WriteReport VolumeWriter::finish_short() {
  require_open();
  const uint32_t frames = frames_of_short();
  const uint64_t frames_in_all = fit_options_.part ? fit_options_.part->end_given : settings_.dims[3];
  const uint64_t all =
      input_ == Input::frames ? frames_in_all : static_cast<uint64_t>(fit().lattice().layers());
  const bool whole = settings_.dims[3] == 0 || added_.front() == all;
  if (fit_options_.part && !whole)
    fail(Code::unsupported, "a part of a series has the frames that it was made for");
  if (fit_options_.periodic && !whole)
    fail(Code::unsupported,
         "writer: a periodic series ends with the frame that leads to its first, and sooner ", "it is none");
  if (!whole) {
    if (frames == 1 && (input_ == Input::layers || fit().has_begun()))
      fail(Code::wrong_state,
           "writer: one frame alone is a lattice without time, and layers in time are there");
    require_no_fewer(frames);
    check_times(frames);
    run_step([&] { shorten(frames); });
  }
  return finish();
}

WriteReport VolumeWriter::finish() {
  WriteReport report;
  require_open();
  check_end();
  run_step([&] {
    now_.trigger = settings_.dims[3];
    FitReport result = finish_fits();
    make_container();
    store_masks();
    // The error of coding is known of what was coded.
    report.coding_rmse = coding_rmse(std::span(result.channels).first(added_.size()));
    if (continued_) continued_->add_to(result, context_);
    complete_info(result);

    const VolumeInfo& info = container_->info();
    report.frames =
        part_ ? part_->fit.counted.end_frame() - part_->fit.counted.first_frame() : result.lattice.dims[3];
    for (size_t c = 0; c < added_.size(); ++c) {
      const FitChannelReport& r = result.channels[c];
      report.add(r, part_ ? r.source_samples : info.cc_samples(), info.channels[c].source_type);
      source_ranges_.push_back(r.source_range);
      std::string warning = air_warning(info.channels[c], r);
      if (!warning.empty()) warnings_.push_back(std::move(warning));
      if (const RoundTrip* const measured = measuring_.round_trip())
        report.corrected += measured->errors(static_cast<int>(c)).corrected;
    }
    const RoundTrip* const measured = measuring_.round_trip();
    std::string gap = gap_warning(times_, measured ? measured->frames() : std::vector<uint32_t>{});
    if (!gap.empty() && !part_) warnings_.push_back(std::move(gap));
    // A block counts its sites with those outside.
    if (!is_block())
      report.take_outside(result.lattice, part_ ? part_->fit.first_own : 0,
                          part_ ? part_->fit.end_own : result.lattice.layers(), added_.size());
    if (measured) report.frames_measured = measured->frames().size();
    if (continued_) report.slabs_reused = continued_->slabs() * added_.size();
    if (continued_) continued_->close_file();
    const Bcc4Report written = container_->finish(context_);
    report.set_file(written);
  });
  state_ = State::finished;
  try {
    context_.progress.report(1);
  } catch (const Error&) {
    // Too late to cancel: the file has its name.
  }
  return report;
}

// The report of level 0, with the channels of coarser levels behind its own.
FitReport VolumeWriter::finish_fits() {
  for (const auto& level : fits_) level->fit().end();
  for (int c = 0; c < static_cast<int>(added_.size()); ++c)
    for (const auto& level : fits_) {
      level->finish_channel(c);
      measuring_.with_level(level->level(), [&](RoundTrip& r) { r.measure_ready(c); });
    }
  return report_of_fits();
}

FitReport VolumeWriter::report_of_fits() const {
  FitReport result = fit().report();
  for (size_t l = 1; l < fits_.size(); ++l)
    for (const FitChannelReport& r : fits_[fits_.size() - 1 - l]->fit().report().channels)
      result.channels.push_back(level_counts(r));
  return result;
}

void VolumeWriter::complete_info(const FitReport& result) {
  VolumeInfo& info = container_->info();
  info.lattice = result.lattice;
  for (size_t l = 1; l < fits_.size(); ++l) {
    LevelInfo& level = info.levels[l - 1];
    level.lattice = fits_[fits_.size() - 1 - l]->fit().lattice();
    for (size_t c = 0; c < added_.size(); ++c)
      level.channels[c].clamped = result.channels[l * added_.size() + c].clamped;
  }
  info.time = input_ == Input::frames ? time_map(static_cast<uint32_t>(times_.size())) : initial_.time;
  require_bounds(result);
  info.sources = initial_.sources;
  info.attributes = initial_.attributes;
  for (size_t c = 0; c < added_.size(); ++c) {
    describe_channel(result.channels[c], info.channels[c]);
    tell_base(c, info.channels[c]);
    // A part knows nothing of the rest of the series.
    if (const RoundTrip* const r = measuring_.round_trip(); r && !part_ && info.channels[c].residuals.local)
      add_measured(r->errors(static_cast<int>(c)), result.channels[c].source_range, c, r->frames().size(),
                   info.errors);
  }
  if (!part_) describe_level_errors(result);
  if (part_)
    describe_part(result);
  else if (input_ == Input::frames && !result.lattice.periodic) {
    const int32_t lasting = lasting_slabs(result.lattice, fit_options_, layer_use(), result.lattice.dims[3]);
    describe_tail(lasting, result.channels, info);
    // A series that ended sooner than was said has counted other slabs by themselves.
    if (info.counts && lasting * info.slab_layers != fit_options_.lasting_layers) info.counts.reset();
  }
}

void VolumeWriter::tell_base(size_t c, ChannelInfo& channel) const {
  if (const RoundTrip* const r = measuring_.round_trip())
    channel.residuals.base = r->base(static_cast<int>(c));
}

void VolumeWriter::describe_level_errors(const FitReport& result) {
  VolumeInfo& info = container_->info();
  if (info.levels.empty()) return;
  for (size_t c = 0; c < added_.size(); ++c) {
    const bool told = info.channels[c].residuals.local; // level 0, that is
    for (size_t l = told || continued_ ? 1 : 0; l < fits_.size(); ++l) {
      const RoundTrip* const r = l == 0 ? measuring_.round_trip() : measuring_.level(static_cast<int>(l));
      if (r && !r->frames().empty())
        add_measured_level(r->errors(static_cast<int>(c)), result.channels[c].source_range, c, l,
                           r->frames().size(), info.errors);
    }
    if (!continued_) continue;
    for (const MeasuredError& e : continued_->info().errors)
      if (e.channel == c && (e.level > 0 || !told)) info.errors.push_back(e);
  }
  sort_errors(info.errors);
}

// Times of frames, in the short form where they are evenly spaced.
TimeMap VolumeWriter::time_map(uint32_t frames) const {
  const auto times = std::span(times_).first(frames);
  TimeMap map{.uniform = true,
              .first = times.front(),
              .step = 1,
              .times = {},
              .unit = container_->info().time.unit,
              .epoch = {}};
  if (frames > 1) map.step = (times.back() - times.front()) / (frames - 1.0);
  for (size_t i = 0; i < times.size() && map.uniform; ++i)
    map.uniform = std::fabs(times[i] - map.at(i)) <= 1e-9 * map.step;
  if (!map.uniform) map.times.assign(times.begin(), times.end());
  return map;
}

void VolumeWriter::require_bounds(const FitReport& result) const {
  if (!(settings_.psnr > 0) || part_) return; // a part knows nothing of the rest of the series
  for (size_t c = 0; c < added_.size(); ++c) {
    const ChannelSettings& channel = settings_.channels[c];
    require_psnr(channel.name, measuring_.round_trip()->errors(static_cast<int>(c)),
                 result.channels[c].source_range, settings_.psnr,
                 settings_.wavelets && channel.wavelet_error == 0 ? channel.range : std::nullopt);
  }
}

// Turns what is said about the series into what a part says.
void VolumeWriter::describe_part(const FitReport& result) {
  VolumeInfo& info = container_->info();
  PartInfo out;
  out.block = part_->fit.counted;
  out.series = series_checksum(info, settings_checksum(settings_.psnr));
  out.writes = std::move(writes_);
  PartReport report;
  report.psnr = settings_.psnr;
  report.lasting = lasting_slabs(result.lattice, fit_options_, layer_use(), result.lattice.dims[3]);
  for (size_t c = 0; c < result.channels.size(); ++c) {
    PartChannelReport& channel = report.channels.emplace_back();
    channel.fit = result.channels[c];
    const size_t level = c / info.channels.size(), of_level = c % info.channels.size();
    if (const RoundTrip* const measured =
            level == 0 ? measuring_.round_trip() : measuring_.level(static_cast<int>(level)))
      for (size_t i = 0; i < measured->frames().size(); ++i) {
        channel.measured.push_back(measured->frames()[i]);
        channel.errors.push_back(measured->frame_errors(static_cast<int>(of_level), i));
      }
    if (level > 0) continue;
    channel.bound = info.channels[c].residuals.bound;
    // Nothing is said about frames of other parts.
    info.channels[c].residuals.bound = 0;
    info.channels[c].frames.clear();
  }
  out.statistics = write_part_report(report);
  info.part = std::move(out);
}

} // namespace bccsplat
