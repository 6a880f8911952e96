// SPDX-License-Identifier: Apache-2.0
// What a writer settles before its first data, and what a host may ask and say of the series meanwhile.
#include "store/volume_writer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "formats/bcc4/coding/tile.h"
#include "formats/bcc4/metadata.h"
#include "store/block.h"
#include "store/channel_info.h"

namespace bccsplat {
namespace {

// Layers beyond each end of a predicted series; the outermost makes up for the mirrors behind it.
constexpr int32_t end_layers = 2;
// The same where a host gives them: these do not make up for the mirrors behind them.
constexpr int32_t given_end_layers = 4;
// Part of an axis that the planes outside are at most, asked for and unasked.
constexpr int32_t most_asked = 5, most_unasked = 16;
// Layers of a series that is predicted unasked: the ends then add at most a fifth, which series that are
// smooth in time give back at equal bytes (tests/bench/notes/ends.md).
constexpr int32_t fewest_layers = 10 * end_layers;

// A series that is appended to keeps the slabs it has.
int32_t slab_layers_of(const WriterSettings& s) {
  if (s.continuity == Continuity::append && file_exists(s.path))
    return Bcc4Reader::open(open_file_source(s.path))->info().slab_layers;
  if (s.wavelets)
    return slab_layers_of_wavelets(s.lattice, static_cast<double>(s.dims[0]) * s.dims[1] * s.dims[2]);
  return slab_layers_for(s.coefficients);
}

// The root mean square error that is asked for; 0: none. Of a bound the rest is left to corrections, and
// something to the rounding of codes.
double asked_wavelet_error(const WriterSettings& s, const ChannelSettings& channel) {
  constexpr double of_bound = .42, of_psnr = .995, decibels = 20;
  if (channel.wavelet_error > 0) return channel.wavelet_error;
  double error = std::numeric_limits<double>::infinity();
  if (channel.abs_error > 0) error = of_bound * channel.abs_error;
  if (s.psnr > 0 && channel.range)
    error = std::min(error, of_psnr * (channel.range->high - channel.range->low) /
                                std::pow(10.0, s.psnr / decibels));
  return std::isfinite(error) ? error : 0;
}

// That of a file to be appended to; 0: there is none.
double stored_wavelet_error(const WriterSettings& s, size_t channel) {
  if (s.continuity != Continuity::append || !file_exists(s.path)) return 0;
  const auto file = Bcc4Reader::open(open_file_source(s.path));
  const auto& channels = file->info().channels;
  return channel < channels.size() ? channels[channel].wavelet_error : 0;
}

// The root mean square error that a channel's wavelets may have. A series that is appended to keeps its own,
// unless less is asked for, which is refused later.
double wavelet_error_of(const WriterSettings& s, size_t channel) {
  const double asked = asked_wavelet_error(s, s.channels[channel]), stored = stored_wavelet_error(s, channel);
  if (stored > 0 && (asked == 0 || stored <= asked)) return stored;
  if (asked > 0) return asked;
  fail(Code::invalid_argument, "channel ", s.channels[channel].name,
       ": wavelets need an error to keep: wavelet_errors, abs_error, or psnr and the range of the values");
}

// A series that is appended to keeps the holes of its lattice, as older files have them.
bool marks_holes(const WriterSettings& s) {
  if (s.continuity != Continuity::append || !file_exists(s.path)) return false;
  const auto file = Bcc4Reader::open(open_file_source(s.path));
  const auto& channels = file->info().channels;
  return std::any_of(channels.begin(), channels.end(), [](const ChannelInfo& c) { return c.holes > 0; }) &&
         std::all_of(channels.begin(), channels.end(), [](const ChannelInfo& c) { return c.masks.empty(); });
}

// Returns how many planes samples reach under a kernel. Its prefilter looks further, but what is 3 planes or
// more beyond changes nothing that can be measured (tests/bench/notes/fit.md).
int32_t reach_planes(const WriterSettings& s) {
  constexpr int32_t beyond = 2;
  return static_cast<int32_t>(
             std::ceil(make_kernel(s.recommended_kernel).space.radius * std::numbers::sqrt2)) +
         beyond;
}

// Returns how far from data samples are filled: three distances of the coarsest level. More brings no level
// closer to its data (tests/bench/notes/blocks.md).
double filled_samples(const WriterSettings& s) {
  constexpr double distances = 3;
  return std::ldexp(distances * std::max({s.scales[0], s.scales[1], s.scales[2]}), s.levels);
}

FitOptions fit_options_of(const WriterSettings& s) {
  FitOptions options;
  options.lattice = s.lattice;
  options.dims = s.dims;
  options.scales = s.scales;
  options.filter = s.filter;
  options.lowpass = s.lowpass;
  options.nonfinite = s.nonfinite;
  options.masks = s.nonfinite == NonFinite::hole && !marks_holes(s);
  if (options.masks) options.mask_reach = reach_planes(s);
  options.slab_layers = slab_layers_of(s);
  options.turning = s.turning;
  options.fixed_predictions = s.fixed_predictions;
  if (s.nonfinite == NonFinite::hole && s.fixed_predictions) options.fill = FillReach::of(filled_samples(s));
  options.periodic = s.ends == Ends::periodic && s.dims[3] > 1; // check_settings refuses other numbers
  return options;
}

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

// The file that an old one belongs to has been begun anew.
void remove_old_journal(const WriterSettings& s) {
  const std::string journal = s.path + ".journal";
  const bool own = s.continuity == Continuity::journal || s.continuity == Continuity::resume;
  if (!own && file_exists(journal)) create_journal_sink(journal, 0)->commit();
}

} // namespace

VolumeWriter::VolumeWriter(WriterSettings settings, std::unique_ptr<ByteSink> stream, const Context& context)
    : settings_(std::move(settings)), context_(context), sink_(std::move(stream)),
      fit_options_(fit_options_of(settings_)), added_(settings_.channels.size()), measuring_(settings_) {
  check_settings();
  begin_info();
  if (settings_.continuity == Continuity::append) require_continued_file();
  if (settings_.part) begin_part();
  if (settings_.continuity == Continuity::journal || settings_.continuity == Continuity::resume)
    require_same_series();
  if (!sink_) {
    sink_ =
        create_file_sink(settings_.path, settings_.overwrite || settings_.continuity == Continuity::append,
                         partial_of(settings_.continuity));
    remove_old_journal(settings_);
  }
}

void VolumeWriter::check_settings() const {
  const WriterSettings& s = settings_;
  if (sink_ && s.continuity != Continuity::none)
    fail(Code::unsupported, "writer: a stream's unfinished work is the host's own; partial must be DEFAULT");
  for (size_t a = 0; a < 3; ++a)
    if (s.dims[a] == 0) fail(Code::invalid_argument, "writer: dims[", a, "] is 0");
  if (s.lowpass && s.lattice == LatticeKind::cc)
    fail(Code::invalid_argument, "writer: a low-pass is of use on D4* and BCC only");
  if (s.live_slabs > 0 && s.part)
    fail(Code::unsupported,
         "writer: parts of a series, and what continues a file, are seen when they are finished");
  if (s.levels < 0 || s.levels > most_levels)
    fail(Code::invalid_argument, "writer: ", s.levels, " coarser levels, not 0 to ", most_levels);
  for (const ChannelSettings& c : s.channels)
    if (!(c.abs_error >= 0 && std::isfinite(c.abs_error)))
      fail(Code::invalid_argument, "writer: abs_error must be finite and not negative");
  if (!(s.psnr >= 0 && std::isfinite(s.psnr)))
    fail(Code::invalid_argument, "writer: psnr must be finite and not negative");
  if ((measuring_.required() || s.coefficients || s.wavelets) && s.dims[3] == 0)
    fail(Code::invalid_argument,
         "writer: a bound, measuring, coefficients, or wavelets need the number of frames in dims[3]; where "
         "it is not known yet give the most that may come, and end with finish_short");
  if (s.wavelets && s.coefficients)
    fail(Code::invalid_argument, "writer: wavelets are of samples, not of coefficients");
  if (s.ends == Ends::periodic) check_periodic();
  for (size_t a = 0; a < 3; ++a)
    if (s.turning[a] && !s.axes[a].coordinates.empty())
      fail(Code::unsupported, "writer: axis ", "xyz"[a],
           " is periodic, and its coordinates are unevenly spaced; a periodic axis takes none");
  for (size_t a = 0; a < 3; ++a)
    if (s.turning[a] && (s.dims[a] < 2 || (s.faces == Faces::along && s.faces_along[a])))
      fail(Code::invalid_argument,
           "writer: a periodic axis has two samples at least, and no faces to predict");
  if (s.lattice == LatticeKind::bcc && s.dims[3] != 1)
    fail(Code::invalid_argument, "writer: lattice BCC holds one frame; set dims[3] to 1 or choose D4STAR");
  for (size_t c = 0; c < s.channels.size(); ++c) {
    const ChannelSettings& channel = s.channels[c];
    if (channel.name.empty()) fail(Code::invalid_argument, "channel ", c, ": the name is empty");
    for (size_t other = 0; other < c; ++other)
      if (s.channels[other].name == channel.name)
        fail(Code::invalid_argument, "two channels are named ", channel.name);
    if (!(channel.threshold >= 0 && std::isfinite(channel.threshold)) || !std::isfinite(channel.air))
      fail(Code::invalid_argument, "channel ", channel.name,
           ": air and air_threshold must be finite, the threshold >= 0");
    if (channel.range && !(channel.range->low < channel.range->high && std::isfinite(channel.range->low) &&
                           std::isfinite(channel.range->high)))
      fail(Code::invalid_argument, "channel ", channel.name, ": range must be finite and rise");
  }
}

void VolumeWriter::check_periodic() const {
  const WriterSettings& s = settings_;
  if (s.dims[3] < 2)
    fail(Code::invalid_argument, "writer: a periodic series needs the number of its frames in dims[3], ",
         "at least 2, as a whole number of layers makes a turn");
  if (s.continuity == Continuity::append)
    fail(Code::unsupported, "writer: a periodic series ends where it begins, so that none goes on; ",
         "write it anew");
  if (s.part)
    fail(Code::unsupported, "writer: a periodic series is not written in parts, as its first layers need ",
         "the last frames; write it in one go");
  if (settings_.live_slabs > 0)
    fail(Code::unsupported,
         "writer: a periodic series is not looked at while it is written, as its first layers ", "come last");
}

void VolumeWriter::begin_info() {
  const WriterSettings& s = settings_;
  // Refuses impossible sizes before anything is written.
  if (s.faces == Faces::predict || s.faces == Faces::along)
    fit_options_.margins = outside_planes(given_planes);
  if (s.ends == Ends::predict && s.dims[3] > 1) fit_options_.lead = given_end_layers;
  initial_.lattice = lattice_of(fit_options_, std::max(s.dims[3], 1u));
  initial_.scale = mean_in_space(s.scales), initial_.time_scale = s.scales[3];
  initial_.slab_layers = fit_options_.slab_layers;
  if (s.wavelets) initial_.tile_edge = usual_tile_edge;
  initial_.affine = s.affine;
  initial_.spatial_unit = s.spatial_unit;
  initial_.axes = s.axes;
  check_axes(initial_, Code::invalid_argument);
  initial_.time.unit = s.time_unit;
  if (!s.recommended_kernel.empty())
    initial_.recommended_kernel = make_kernel(s.recommended_kernel).name;
  else if (!s.coefficients && s.scales[3] == 1 && initial_.lattice.sites_are_samples())
    initial_.recommended_kernel = make_kernel("exact").name;
  else if (s.bounds_samples() || s.psnr > 0 || s.coefficients) // must not depend on a reader's default
    initial_.recommended_kernel = make_kernel("").name;
  if (s.coefficients) {
    const Kernel kernel = make_kernel(initial_.recommended_kernel);
    initial_.coefficient_parameters = kernel_parameters(kernel);
    initial_.coefficient_kernel = kernel.name;
  }
  for (size_t c = 0; c < s.channels.size(); ++c) {
    const ChannelSettings& channel = s.channels[c];
    ChannelInfo& info = initial_.channels.emplace_back();
    info.name = channel.name, info.unit = channel.unit;
    info.air = static_cast<float>(channel.air), info.threshold = channel.threshold;
    if (s.wavelets) info.wavelet_error = wavelet_error_of(s, c);
  }
}

void VolumeWriter::begin_part() {
  const PartSettings& asked = *settings_.part;
  if (settings_.dims[3] == 0)
    fail(Code::invalid_argument, "a part needs the number of frames of the series in dims[3]");
  if (settings_.continuity == Continuity::append) {
    continued_.emplace(settings_, fit_options_, layer_use());
    initial_.lattice = continued_->lattice();
    fit_options_.part = continued_->rest().fit;
  } else {
    const uint32_t frames = settings_.dims[3];
    if (asked.block.first_frame() >= asked.block.end_frame() || asked.block.end_frame() > frames)
      fail(Code::invalid_argument, "a part of frames ", asked.block.first_frame(), " to ",
           asked.block.end_frame(), " (excluded): the series has ", frames, ", and a part has at least one");
    const SeriesBlock block = block_in(settings_.dims, asked.block);
    if (!block.all_space()) check_block(settings_);
    for (const ChannelSettings& channel : settings_.channels)
      if (settings_.nonfinite == NonFinite::clamp && !channel.range)
        fail(Code::invalid_argument, "channel ", channel.name,
             ": what a part clamps to is the range of the series, which it must be told");
    require_rising(asked.times);
    fit_options_.lead = predicted_layers(), fit_options_.margins = outside_planes(frame_planes);
    initial_.lattice = lattice_of(fit_options_, settings_.dims[3]);
    if (!block.all_space()) check_block_lattice(settings_, initial_.lattice);
    const auto plan = [&](std::span<const uint32_t> measured) {
      LayerUse use = layer_use();
      use.measured = measured;
      part_ = part_of_series(initial_.lattice, fit_options_, use, block);
    };
    const std::vector<uint32_t> measured = measuring_.choose_frames(0, frames);
    if (!measuring_.attempt([&] { plan(measured); })) plan({});
    begin_earlier(asked.early_frames, part_->fit);
    fit_options_.part = part_->fit;
    if (!block.all_space()) begin_block();
  }
  fit_options_.lead = initial_.lattice.lead, fit_options_.margins = initial_.lattice.before;
  times_ = asked.times;
  added_.assign(added_.size(), fit_options_.part->first_given);
}

// Finds what the coarser levels of a block need.
void VolumeWriter::begin_block() {
  const std::vector<FitOptions> levels = level_options();
  FitPart& part = *fit_options_.part;
  if (levels.size() > 1) part.halved = LevelFrames(levels, context_).seen();
  for (const FitOptions& o : levels)
    for (const int64_t reach : mask_reach_of(o, lattice_of(o, o.dims[3])))
      part.masked = std::max(part.masked, reach);
}

// What the first data will settle is taken from the file, and compared when they have come.
void VolumeWriter::require_continued_file() const {
  const WriterSettings& s = settings_;
  if (!file_exists(s.path)) fail(Code::file_not_found, s.path, ": no file to append to");
  const auto file = Bcc4Reader::open(open_file_source(s.path));
  const VolumeInfo& was = file->info();
  require_open_end(was, s.path);
  VolumeInfo now = initial_;
  FitOptions options = fit_options_;
  options.lead = was.lattice.lead, options.margins = was.lattice.before;
  now.lattice = lattice_of(options, std::max({s.dims[3], was.lattice.dims[3], 2u}));
  now.lattice.dims[3] = s.dims[3];
  now.levels = was.levels;
  for (size_t c = 0; c < std::min(s.channels.size(), was.channels.size()); ++c) {
    const ChannelSettings& channel = s.channels[c];
    static_cast<Quantiser&>(now.channels[c]) = static_cast<const Quantiser&>(was.channels[c]);
    now.channels[c].air = static_cast<float>(channel.air);
    if (channel.source_type)
      (void)code_channel(channel, *channel.source_type, s.coefficients, now.channels[c]);
    else if (channel.value_type && !s.coefficients)
      now.channels[c].type = *channel.value_type;
  }
  // The numbers of the frames are compared as a part's, where they are given as one.
  require_continuable(was, now, s.part ? 0 : s.dims[3], s.path);
}

void VolumeWriter::require_same_series() {
  const bool of_part = fit_options_.part.has_value();
  journal_options_ = journal_options(settings_, initial_.recommended_kernel,
                                     of_part ? fit_options_.lead : predicted_layers(),
                                     of_part ? fit_options_.margins : outside_planes(frame_planes));
  if (settings_.continuity == Continuity::resume)
    Bcc4Journal::require_options(settings_.path, journal_options_);
}

// A series that is appended to keeps the layers it has.
int32_t VolumeWriter::predicted_layers() const {
  const WriterSettings& s = settings_;
  if (s.dims[3] == 1) return 0;
  if (s.continuity == Continuity::append)
    return Bcc4Reader::open(open_file_source(s.path))->info().lattice.lead;
  if (s.ends != Ends::automatic) return s.ends == Ends::predict ? end_layers : 0;
  if (s.lattice == LatticeKind::cc || s.dims[3] == 0) return 0;
  const Lattice4 lattice = Lattice4::fit(s.lattice, s.dims, s.scales);
  return lattice.layers() < fewest_layers ? 0 : end_layers;
}

// A series that is appended to keeps the levels it has.
int VolumeWriter::levels() const {
  if (settings_.continuity == Continuity::append)
    return static_cast<int>(Bcc4Reader::open(open_file_source(settings_.path))->info().levels.size());
  return settings_.levels;
}

// `wanted` or none, by axis. A series that is appended to keeps the planes it has.
Int3 VolumeWriter::outside_planes(int32_t wanted, int level) const {
  const WriterSettings& s = settings_;
  if (s.continuity == Continuity::append)
    return Bcc4Reader::open(open_file_source(s.path))->info().level(level).lattice.before;
  LatticeScales scales = s.scales;
  for (size_t a = 0; a < 3; ++a) scales[a] = std::ldexp(scales[a], level);
  const Lattice4 lattice = Lattice4::fit(s.lattice, {s.dims[0], s.dims[1], s.dims[2], 1}, scales);
  Int3 planes{};
  if (s.faces == Faces::mirror || (s.faces == Faces::automatic && lattice.sites_are_samples())) return planes;
  const int32_t part = s.faces == Faces::predict ? most_asked : most_unasked;
  for (size_t a = 0; a < 3; ++a) {
    const int32_t last = lattice.space.last[a];
    const bool pays = 2 * wanted * part <= last + 2 * wanted;
    if (s.dims[a] > 1 && !s.turning[a] && (s.faces == Faces::along ? s.faces_along[a] : pays))
      planes[a] = wanted;
  }
  return planes;
}

LayerUse VolumeWriter::layer_use() const { return {settings_.coefficients, initial_.recommended_kernel}; }

void VolumeWriter::set_times(double first, double step) {
  require_open();
  if (input_ == Input::frames) fail(Code::wrong_state, "set_times: frames are given with their times");
  initial_.time.first = first, initial_.time.step = step;
}

void VolumeWriter::take_text(uint64_t bytes, uint64_t replaced) {
  constexpr uint64_t most = Bcc4Limits{}.metadata_bytes / 2; // the other half is for what writers say
  const uint64_t all = text_bytes_ - replaced + bytes;
  if (all > most)
    fail(Code::limit_exceeded, "writer: attributes and sources of ", all, " bytes, the limit is ", most);
  text_bytes_ = all;
}

void VolumeWriter::set_attribute(const std::string& key, const std::string& value) {
  require_open();
  auto& attributes = initial_.attributes;
  const auto it =
      std::find_if(attributes.begin(), attributes.end(), [&](const auto& a) { return a.first == key; });
  if (it != attributes.end()) {
    take_text(value.size(), it->second.size());
    it->second = value;
  } else {
    take_text(key.size() + value.size(), 0);
    attributes.emplace_back(key, value);
  }
}

void VolumeWriter::add_source(SourceInfo source) {
  require_open();
  take_text(source.name.size(), 0);
  initial_.sources.push_back(std::move(source));
}

void VolumeWriter::require_channel(uint32_t channel) const {
  if (channel >= added_.size())
    fail(Code::not_found, "channel ", channel, " of a writer with ", added_.size());
}

LayerGeometry VolumeWriter::layer_geometry(int64_t number) const {
  if (settings_.dims[3] == 0) fail(Code::wrong_state, "layers need the number of frames: set dims[3]");
  const Lattice4& lattice = initial_.lattice;
  if (number < 0 || number >= lattice.layers())
    fail(Code::not_found, "layer ", number, " of ", lattice.layers());
  const auto layer = static_cast<int32_t>(number);
  const int coset = lattice.coset(layer);
  const Vec3 origin = lattice.site_position(coset, {0, 0, 0});
  return {coset,
          {origin, lattice.site_position(coset, {1, 1, 1}) - origin, lattice.space.dims(coset),
           lattice.is_static() ? 0 : lattice.layer_frame(layer)},
          lattice.layers()};
}

std::array<uint64_t, 2> VolumeWriter::given_frames() const {
  const auto& part = fit_options_.part;
  return {part ? part->first_given : 0, part ? part->end_given : settings_.dims[3]};
}

Region VolumeWriter::given_samples() const {
  const Region all{{}, {settings_.dims[0], settings_.dims[1], settings_.dims[2]}};
  if (!is_block()) return all;
  return scope_of(fit_options_, initial_.lattice).given;
}

MeasuredErrors VolumeWriter::measured(uint32_t channel, int64_t index) const {
  require_channel(channel);
  if (state_ != State::finished) fail(Code::wrong_state, "writer: errors are known after finish");
  const RoundTrip* const r = measuring_.round_trip();
  if (!r || r->frames().empty() || index < -1 || index >= static_cast<int64_t>(r->frames().size()))
    fail(Code::not_found, "measured frame ", index, " of ", r ? r->frames().size() : 0);
  const Range& range = source_ranges_[channel];
  const int c = channel;
  MeasuredErrors out{0, range.high - range.low, {}};
  if (index < 0) {
    out.errors = r->errors(c);
    out.frame = out.errors.frame;
  } else {
    out.errors = r->frame_errors(c, index);
    out.frame = r->frames()[index];
  }
  return out;
}

} // namespace bccsplat
