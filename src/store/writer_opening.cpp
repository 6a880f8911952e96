// SPDX-License-Identifier: Apache-2.0
// Works out the lattice, its ends and faces, and how channels are coded; of a file that is appended to it
// takes what that has already.
#include "store/writer_opening.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "base/error.h"
#include "base/files.h"
#include "formats/bcc4/coding/tile.h"
#include "formats/bcc4/encode/encode_tile.h"
#include "formats/bcc4/labels_attribute.h"
#include "formats/bcc4/metadata.h"
#include "store/block.h"
#include "store/channel_info.h"
#include "store/fingerprint.h"
#include "store/level_fit.h"
#include "store/level_frames.h"

namespace bccsplat {
namespace {

// Layers beyond each end of a predicted series; the outermost makes up for the mirrors behind it.
constexpr int32_t end_layers = 2;
// The same where a host gives them: these do not make up for the mirrors behind them.
constexpr int32_t given_end_layers = 4;
// Planes outside each face: of frames, which make up for the mirrors behind them (fit/beyond/face_table.h),
// and of layers and fields, which do not.
constexpr int32_t frame_planes = 2, given_planes = 4;
// Part of an axis that the planes outside are at most, asked for and unasked.
constexpr int32_t most_asked = 5, most_unasked = 16;
// Layers of a series that is predicted unasked: the ends then add at most a fifth, which series that are
// smooth in time give back at equal bytes (tests/bench/notes/ends.md).
constexpr int32_t fewest_layers = 10 * end_layers;

// Null where nothing is appended to, or there is no file yet.
std::shared_ptr<const Bcc4Reader> open_old(const WriterSettings& s) {
  if (s.continuity != Continuity::append || !file_exists(s.path)) return nullptr;
  return Bcc4Reader::open(open_file_source(s.path));
}

// A series that is appended to keeps the slabs it has.
int32_t slab_layers_of(const WriterSettings& s, const Bcc4Reader* old) {
  if (old) return old->info().slab_layers;
  if (s.wavelets)
    return slab_layers_of_wavelets(s.lattice, static_cast<double>(s.dims[0]) * s.dims[1] * s.dims[2]);
  return slab_layers_of_samples;
}

// The root mean square error that is asked for; 0: none. A bound leaves the rest to corrections, and
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

// Where a bound is kept by corrections, the error that is chosen for it is none that codes cannot keep.
double with_rounding(const ChannelSettings& asked, double error, double scale) {
  constexpr double of_code = .3; // more than the root of 1/12
  return asked.abs_error > 0 && asked.wavelet_error == 0 ? std::max(error, of_code * scale) : error;
}

// The root mean square error that a channel's wavelets may have. A series that is appended to keeps its own,
// unless less is asked for, which is refused later.
double wavelet_error_of(const WriterSettings& s, const Bcc4Reader* old, size_t channel) {
  double asked = asked_wavelet_error(s, s.channels[channel]), stored = 0;
  if (old && channel < old->info().channels.size()) {
    const ChannelInfo& was = old->info().channels[channel];
    stored = was.wavelet_error, asked = with_rounding(s.channels[channel], asked, was.scale);
  }
  if (stored > 0 && (asked == 0 || stored <= asked)) return stored;
  if (asked > 0) return asked;
  fail(Code::invalid_argument, "channel ", s.channels[channel].name,
       ": wavelets need an error to keep: wavelet_errors, abs_error, or psnr and the range of the values");
}

// A series that is appended to keeps the holes of its lattice, as older files have them.
bool marks_holes(const Bcc4Reader* old) {
  if (!old) return false;
  const auto& channels = old->info().channels;
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

// A series that is appended to keeps the layers it has.
int32_t predicted_layers(const WriterSettings& s, const Bcc4Reader* old) {
  if (s.dims[3] == 1) return 0;
  if (old) return old->info().lattice.lead;
  if (s.ends != Ends::automatic) return s.ends == Ends::predict ? end_layers : 0;
  if (s.lattice == LatticeKind::cc || s.dims[3] == 0) return 0;
  const Lattice4 lattice = Lattice4::fit(s.lattice, s.dims, s.scales);
  return lattice.layers() < fewest_layers ? 0 : end_layers;
}

// `wanted` or none, by axis. A series that is appended to keeps the planes it has.
Int3 outside_planes(const WriterSettings& s, const Bcc4Reader* old, int32_t wanted, int level = 0) {
  if (old) return old->info().level(level).lattice.before;
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

// A series that is appended to keeps the levels it has.
int levels_of(const WriterSettings& s, const Bcc4Reader* old) {
  return old ? static_cast<int>(old->info().levels.size()) : s.levels;
}

FitOptions fit_options_of(const WriterSettings& s, const Bcc4Reader* old) {
  FitOptions options;
  options.lattice = s.lattice;
  options.dims = s.dims;
  options.scales = s.scales;
  options.lowpass = s.lowpass;
  options.nonfinite = s.nonfinite;
  options.masks = s.nonfinite == NonFinite::hole && !marks_holes(old);
  if (options.masks) options.mask_reach = reach_planes(s);
  options.slab_layers = slab_layers_of(s, old);
  options.turning = s.turning;
  options.fixed_predictions = s.fixed_predictions;
  if (s.nonfinite == NonFinite::hole && s.fixed_predictions) options.fill = FillReach::of(filled_samples(s));
  options.periodic = s.ends == Ends::periodic && s.dims[3] > 1; // check_settings refuses other numbers
  return options;
}

// The kernel that a file recommends; empty: readers choose.
std::string recommended_kernel(const WriterSettings& s, const Lattice4& lattice) {
  if (!s.recommended_kernel.empty()) return make_kernel(s.recommended_kernel).name;
  if (s.scales[3] == 1 && lattice.sites_are_samples()) return make_kernel("exact").name;
  // What is promised must not depend on a reader's default.
  return s.bounds_samples() || s.psnr > 0 ? make_kernel("").name : std::string();
}

void require_wavelet_type(const ChannelInfo& c) {
  if (c.type != ValueType::u8 && c.type != ValueType::u16)
    fail(Code::invalid_argument, "channel ", c.name,
         ": wavelets are of samples stored as U8 or U16; give value_type U16 and the range of the values");
}

// Rounded to codes, samples of whole numbers come back as they were where they are off by less than half a
// code, and are off by more otherwise.
bool is_linear(const VolumeInfo& info, const ChannelInfo& c) {
  constexpr double of_code = .5;
  return !info.lattice.space.bcc && c.wavelet_error >= of_code * c.scale;
}

} // namespace

WriterOpening::WriterOpening(WriterSettings settings, bool to_stream, Measuring& measuring,
                             const Context& context)
    : settings_(std::move(settings)),
      old_(open_old(settings_)), settled_{.info = {}, .fit = fit_options_of(settings_, old_.get())} {
  check_settings(settings_, to_stream);
  begin_info();
  if (settings_.continuity == Continuity::append) require_continued_file();
  if (settings_.part) begin_part(measuring, context);
  if (settings_.keeps_journal()) begin_journal();
}

void WriterOpening::begin_info() {
  const WriterSettings& s = settings_;
  VolumeInfo& info = settled_.info;
  // Refuses impossible sizes before anything is written.
  if (s.faces == Faces::predict || s.faces == Faces::along)
    settled_.fit.margins = outside_planes(s, old_.get(), given_planes);
  if (s.ends == Ends::predict && s.dims[3] > 1) settled_.fit.lead = given_end_layers;
  info.lattice = lattice_of(settled_.fit, std::max(s.dims[3], 1u));
  info.scale = mean_in_space(s.scales), info.time_scale = s.scales[3];
  info.slab_layers = settled_.fit.slab_layers;
  if (s.wavelets) info.tile_edge = usual_tile_edge;
  info.affine = s.affine;
  info.spatial_unit = s.spatial_unit;
  info.axes = s.axes;
  check_axes(info, Code::invalid_argument);
  info.time.unit = s.time_unit;
  info.recommended_kernel = recommended_kernel(s, info.lattice);
  for (size_t c = 0; c < s.channels.size(); ++c) {
    const ChannelSettings& channel = s.channels[c];
    ChannelInfo& of = info.channels.emplace_back();
    of.name = channel.name, of.unit = channel.unit;
    of.air = static_cast<float>(channel.air), of.threshold = channel.threshold;
    if (s.wavelets) of.wavelet_error = wavelet_error_of(s, old_.get(), c);
    if (channel.labels)
      info.attributes.emplace_back(labels_attribute(channel.name), *channel.labels ? "yes" : "no");
  }
}

// What the first data will settle is taken from the file, and compared when they have come.
void WriterOpening::require_continued_file() const {
  const WriterSettings& s = settings_;
  if (!old_) fail(Code::file_not_found, s.path, ": no file to append to");
  const VolumeInfo& was = old_->info();
  require_open_end(was, s.path);
  VolumeInfo now = info();
  FitOptions options = fit();
  options.lead = was.lattice.lead, options.margins = was.lattice.before;
  now.lattice = lattice_of(options, std::max({s.dims[3], was.lattice.dims[3], 2u}));
  now.lattice.dims[3] = s.dims[3];
  now.levels = was.levels;
  for (size_t c = 0; c < std::min(s.channels.size(), was.channels.size()); ++c) {
    const ChannelSettings& channel = s.channels[c];
    static_cast<Quantiser&>(now.channels[c]) = static_cast<const Quantiser&>(was.channels[c]);
    now.channels[c].air = static_cast<float>(channel.air);
    if (channel.source_type)
      (void)code_channel(channel, *channel.source_type, now.channels[c]);
    else if (channel.value_type)
      now.channels[c].type = *channel.value_type;
  }
  // The numbers of the frames are compared as a part's, where they are given as one.
  require_continuable(was, now, s.part ? 0 : s.dims[3], s.path);
}

void WriterOpening::begin_part(Measuring& measuring, const Context& context) {
  FitOptions& options = settled_.fit;
  Lattice4& lattice = settled_.info.lattice;
  if (frames() == 0)
    fail(Code::invalid_argument, "a part needs the number of frames of the series in dims[3]");
  if (old_) {
    continued_.emplace(*old_, settings_, options);
    lattice = continued_->lattice();
    options.part = continued_->rest().fit;
  } else {
    plan_part(measuring, context);
  }
  options.lead = lattice.lead, options.margins = lattice.before;
}

void WriterOpening::plan_part(Measuring& measuring, const Context& context) {
  const PartSettings& asked = *settings_.part;
  Lattice4& lattice = settled_.info.lattice;
  if (asked.block.first_frame() >= asked.block.end_frame() || asked.block.end_frame() > frames())
    fail(Code::invalid_argument, "a part of frames ", asked.block.first_frame(), " to ",
         asked.block.end_frame(), " (excluded): the series has ", frames(), ", and a part has at least one");
  const SeriesBlock block = block_in(settings_.dims, asked.block);
  if (!block.all_space()) check_block(settings_);
  for (const ChannelSettings& channel : settings_.channels)
    if (settings_.nonfinite == NonFinite::clamp && !channel.range)
      fail(Code::invalid_argument, "channel ", channel.name,
           ": what a part clamps to is the range of the series, which it must be told");
  require_rising(asked.times);
  settle_beyond();
  lattice = lattice_of(fit(), frames());
  if (!block.all_space()) check_block_lattice(settings_, lattice);
  const auto plan = [&](std::span<const uint32_t> measured) {
    part_ = part_of_series(lattice, fit(), {info().recommended_kernel, measured}, block);
  };
  const std::vector<uint32_t> measured = measuring.choose_frames(0, frames());
  if (!measuring.attempt([&] { plan(measured); })) plan({});
  begin_earlier(asked.early_frames, part_->fit);
  settled_.fit.part = part_->fit;
  if (is_block()) begin_block(context);
}

// Finds what the coarser levels of a block need.
void WriterOpening::begin_block(const Context& context) {
  const std::vector<FitOptions> levels = level_options();
  FitPart& part = *settled_.fit.part;
  if (levels.size() > 1) part.halved = LevelFrames(levels, context).seen();
  for (const FitOptions& o : levels)
    for (const int64_t reach : mask_reach_of(o, lattice_of(o, o.dims[3])))
      part.masked = std::max(part.masked, reach);
}

// The options in words are those of frames: nobody knows yet what else will come.
void WriterOpening::begin_journal() {
  const bool of_part = fit().part.has_value();
  journal_options_ = bccsplat::journal_options(
      settings_, info().recommended_kernel, of_part ? fit().lead : predicted_layers(settings_, old_.get()),
      of_part ? fit().margins : outside_planes(settings_, old_.get(), frame_planes));
  if (settings_.continuity == Continuity::resume)
    Bcc4Journal::require_options(settings_.path, journal_options_);
}

// Frames are predicted beyond their ends and faces.
void WriterOpening::settle_beyond() {
  settled_.fit.lead = predicted_layers(settings_, old_.get());
  settled_.fit.margins = outside_planes(settings_, old_.get(), frame_planes);
}

std::vector<FitOptions> WriterOpening::level_options() const {
  std::vector<FitOptions> options{fit()};
  for (int level = 1; level <= levels_of(settings_, old_.get()); ++level) {
    FitOptions& o = options.emplace_back(
        options_of_level(fit(), level, outside_planes(settings_, old_.get(), frame_planes, level)));
    if (part_) o.part->bricks = layer_bricks_of(part_->fit.counted, lattice_of(o, o.dims[3]));
  }
  return options;
}

int32_t WriterOpening::lasting_slabs(const Lattice4& lattice) const {
  return bccsplat::lasting_slabs(lattice, fit(), lattice.dims[3]);
}

uint32_t WriterOpening::checksum(std::optional<double> psnr) const {
  const Rules rules{.tiles = settings_.wavelets ? tile_rules : 0};
  return options_checksum(fit(), settings_.levels, bounds_text(settings_), psnr, rules);
}

uint32_t WriterOpening::writer_checksum() const {
  if (part_) return part_checksum(checksum(settings_.psnr), part_->fit);
  return checksum({}) ^ settings_.live_slabs; // which sets offsets
}

void WriterOpening::settle(bool frames, uint32_t first_channel, SourceType first_type) {
  const WriterSettings& s = settings_;
  VolumeInfo& info = settled_.info;
  FitOptions& options = settled_.fit;
  if (!frames && levels_of(s, old_.get()) > 0)
    fail(Code::unsupported,
         "writer: coarser levels are made of frames; layers and fields have level 0 alone");
  options.channels.clear();
  for (size_t c = 0; c < s.channels.size(); ++c)
    options.channels.push_back(
        code_channel(s.channels[c], c == first_channel ? first_type : SourceType::f32, info.channels[c]));
  if (s.wavelets) {
    for (const ChannelInfo& c : info.channels) require_wavelet_type(c);
    for (size_t c = 0; c < s.channels.size(); ++c) {
      ChannelInfo& of = info.channels[c];
      of.wavelet_error = with_rounding(s.channels[c], of.wavelet_error, of.scale);
      of.linear = old_ ? old_->info().channels[c].linear : is_linear(info, of);
    }
  }
  if (frames && !continued_) settle_beyond();
  if (frames && s.wavelets)
    options.lasting_layers = options.slab_layers * lasting_slabs(lattice_of(options, s.dims[3]));
  info.levels.resize(levels_of(s, old_.get()));
  for (LevelInfo& level : info.levels) {
    level.slab_layers = info.slab_layers, level.tile_edge = info.tile_edge;
    level.channels.resize(info.channels.size());
  }
}

void WriterOpening::shorten(uint32_t frames, const Lattice4& lattice) {
  settings_.dims[3] = settled_.fit.dims[3] = frames;
  settled_.info.lattice = lattice;
}

} // namespace bccsplat
