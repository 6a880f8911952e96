// SPDX-License-Identifier: Apache-2.0
// Finishes the fits and the comparison, and puts together what the file, a part of a series and the host are
// told.
#include "store/writer_ending.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "base/error.h"
#include "store/air_warning.h"
#include "store/channel_info.h"
#include "store/fingerprint.h"
#include "store/gap_warning.h"
#include "store/part_report.h"

namespace bccsplat {

WriterEnding::WriterEnding(WriterOpening& opening, LevelFits& fits, Measuring& measuring,
                           WriterOutput& output, const GivenData& given, const Context& context)
    : opening_(opening), fits_(fits), measuring_(measuring), output_(output), given_(given),
      context_(context) {}

void WriterEnding::check() const {
  if (!fits_.begun()) fail(Code::wrong_state, "writer: nothing was added");
  for (int level = fits_.coarsest(); level >= 0; --level) fits_.level(level).check_end();
  check_times(opening_.frames());
  if (opening_.frames() == 0) require_no_fewer(given_.added.front());
}

// A series that goes on does not lose frames of the file.
void WriterEnding::require_no_fewer(uint64_t frames) const {
  if (!opening_.old()) return;
  const uint32_t was = opening_.old()->info().lattice.dims[3];
  if (frames < was)
    fail(Code::wrong_state, opening_.settings().path, ": it has ", was, " frames already, ", frames,
         " were given");
}

void WriterEnding::check_times(uint32_t frames) const {
  if (given_.has_frames() || frames < 2) return;
  const auto rises = [&](double frame) {
    const double first = opening_.info().time.first, step = opening_.info().time.step;
    return first + frame * step > first + (frame - 1) * step;
  };
  if (!rises(1) || !rises(frames - 1.0))
    fail(Code::wrong_state, "times: they do not rise from frame to frame; step is lost beside first");
}

// The frames of a series that ends with what every channel has been given.
uint32_t WriterEnding::frames_given() const {
  if (!fits_.begun()) fail(Code::wrong_state, "writer: nothing was added");
  const uint64_t given = given_.added.front();
  for (size_t c = 0; c < channels(); ++c)
    if (given_.added[c] != given)
      fail(Code::wrong_state, "writer: channel ", c, " was given ", given_.added[c], ", channel 0 ", given);
  if (given_.has_frames()) return static_cast<uint32_t>(given);
  // Layers reach as far as the last one stands, but for those beyond the end.
  const Lattice4& lattice = fits_.lattice();
  const double last = std::floor(lattice.layer_frame(static_cast<int32_t>(given) - 1 - lattice.lead) + 1e-9);
  if (last < 0) fail(Code::wrong_state, "writer: the layers end before the first frame");
  return static_cast<uint32_t>(std::min(last, lattice.last_frame())) + 1;
}

std::optional<uint32_t> WriterEnding::fewer_frames() const {
  const uint32_t frames = frames_given();
  const auto& part = opening_.fit().part;
  const uint64_t all_frames = part ? part->end_given : opening_.frames();
  const uint64_t all = given_.has_frames() ? all_frames : fits_.lattice().layers();
  if (opening_.frames() == 0 || given_.added.front() == all) return std::nullopt;
  if (part) fail(Code::unsupported, "a part of a series has the frames that it was made for");
  if (opening_.fit().periodic)
    fail(Code::unsupported,
         "writer: a periodic series ends with the frame that leads to its first, and sooner ", "it is none");
  if (frames == 1 && (!given_.has_frames() || fits_.fit().has_begun()))
    fail(Code::wrong_state,
         "writer: one frame alone is a lattice without time, and layers in time are there");
  require_no_fewer(frames);
  check_times(frames);
  return frames;
}

void WriterEnding::shorten(uint32_t frames) {
  for (int level = fits_.coarsest(); level >= 0; --level) fits_.level(level).shorten(frames);
  opening_.shorten(frames, fits_.lattice());
  for (int level = fits_.coarsest(); level >= 0; --level)
    measuring_.with_level(level, [&](RoundTrip& r) { r.set_lattice(fits_.lattice(level)); });
}

WriteReport WriterEnding::finish() {
  output_.begin_turn(opening_.frames());
  FitReport result = finish_fits();
  output_.end();
  // The error of coding is known of what was coded.
  const double rmse = coding_rmse(std::span(result.channels).first(channels()));
  if (opening_.continued()) opening_.continued()->add_to(result, context_);
  complete_info(result);
  WriteReport report = report_of(result);
  report.coding_rmse = rmse;
  opening_.close_old();
  report.set_file(output_.finish());
  return report;
}

FitReport WriterEnding::finish_fits() {
  for (int level = fits_.coarsest(); level >= 0; --level) fits_.level(level).end();
  for (int c = 0; c < static_cast<int>(channels()); ++c)
    for (int level = fits_.coarsest(); level >= 0; --level) {
      fits_.level(level).finish_channel(c);
      measuring_.with_level(level, [&](RoundTrip& r) { r.measure_ready(c); });
    }
  return fits_.report();
}

WriteReport WriterEnding::report_of(const FitReport& result) {
  const VolumeInfo& info = output_.info();
  const SeriesPart* const part = opening_.part();
  const RoundTrip* const measured = measuring_.round_trip();
  WriteReport report;
  report.frames =
      part ? part->fit.counted.end_frame() - part->fit.counted.first_frame() : result.lattice.dims[3];
  for (size_t c = 0; c < channels(); ++c) {
    const FitChannelReport& r = result.channels[c];
    report.add(r, part ? r.source_samples : info.cc_samples(), info.channels[c].source_type);
    source_ranges_.push_back(r.source_range);
    std::string warning = air_warning(info.channels[c], r);
    if (!warning.empty()) warnings_.push_back(std::move(warning));
    if (measured) report.corrected += measured->errors(static_cast<int>(c)).corrected;
  }
  std::string gap = gap_warning(given_.times, measured ? measured->frames() : std::vector<uint32_t>{});
  if (!gap.empty() && !part) warnings_.push_back(std::move(gap));
  // A block counts its sites with those outside.
  if (!opening_.is_block())
    report.take_outside(result.lattice, part ? part->fit.first_own : 0,
                        part ? part->fit.end_own : result.lattice.layers(), channels());
  if (measured) report.frames_measured = measured->frames().size();
  if (opening_.continued()) report.slabs_reused = opening_.continued()->slabs() * channels();
  return report;
}

void WriterEnding::complete_info(const FitReport& result) {
  VolumeInfo& info = output_.info();
  fits_.describe_lattices(info);
  require_psnr_met(result);
  output_.describe(given_, static_cast<uint32_t>(given_.times.size()), result, info);
  if (opening_.part()) return describe_part(result);
  describe_errors(result);
  if (!given_.has_frames() || result.lattice.periodic) return;
  const int32_t lasting = opening_.lasting_slabs(result.lattice);
  describe_tail(lasting, result.channels, info);
  // A series that ended sooner than was said has counted other slabs by themselves.
  if (info.counts && lasting * info.slab_layers != opening_.fit().lasting_layers) info.counts.reset();
}

// A continued file keeps what was measured of its frames, but for what corrections promise.
void WriterEnding::describe_errors(const FitReport& result) {
  VolumeInfo& info = output_.info();
  for (size_t c = 0; c < channels(); ++c) {
    const Range& source = result.channels[c].source_range;
    const bool corrected = info.channels[c].residuals.local;
    if (const RoundTrip* const r = measuring_.round_trip(); r && corrected)
      add_measured(r->errors(static_cast<int>(c)), source, c, r->frames().size(), info.errors);
    if (info.levels.empty()) continue;
    for (int l = corrected || opening_.continued() ? 1 : 0; l <= fits_.coarsest(); ++l)
      if (const RoundTrip* const r = measuring_.round_trip(l); r && !r->frames().empty())
        add_measured_level(r->errors(static_cast<int>(c)), source, c, l, r->frames().size(), info.errors);
    if (!opening_.continued()) continue;
    for (const MeasuredError& e : opening_.old()->info().errors)
      if (e.channel == c && (e.level > 0 || !corrected)) info.errors.push_back(e);
  }
  if (!info.levels.empty()) sort_errors(info.errors);
}

void WriterEnding::require_psnr_met(const FitReport& result) const {
  const WriterSettings& s = opening_.settings();
  if (!(s.psnr > 0) || opening_.part()) return; // a part knows nothing of the rest of the series
  for (size_t c = 0; c < channels(); ++c)
    require_psnr(s.channels[c].name, measuring_.round_trip()->errors(static_cast<int>(c)),
                 result.channels[c].source_range, s.psnr,
                 s.wavelets && s.channels[c].wavelet_error == 0 ? s.channels[c].range : std::nullopt);
}

// Turns what is said about the series into what a part says.
void WriterEnding::describe_part(const FitReport& result) {
  VolumeInfo& info = output_.info();
  PartInfo out;
  out.block = opening_.part()->fit.counted;
  out.series = series_checksum(info, opening_.checksum(opening_.settings().psnr));
  out.writes = output_.take_writes();
  PartReport report;
  report.psnr = opening_.settings().psnr;
  report.lasting = opening_.lasting_slabs(result.lattice);
  for (size_t c = 0; c < result.channels.size(); ++c) {
    PartChannelReport& channel = report.channels.emplace_back();
    channel.fit = result.channels[c];
    const size_t level = c / channels(), of_level = c % channels();
    if (const RoundTrip* const measured = measuring_.round_trip(static_cast<int>(level)))
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

MeasuredErrors WriterEnding::measured(uint32_t channel, int64_t index) const {
  const RoundTrip* const r = measuring_.round_trip();
  if (!r || r->frames().empty() || index < -1 || index >= static_cast<int64_t>(r->frames().size()))
    fail(Code::not_found, "measured frame ", index, " of ", r ? r->frames().size() : 0);
  const int c = static_cast<int>(channel);
  const double peak = source_ranges_[channel].high - source_ranges_[channel].low;
  if (index >= 0) return {r->frames()[index], peak, r->frame_errors(c, index)};
  return {r->errors(c).frame, peak, r->errors(c)};
}

} // namespace bccsplat
