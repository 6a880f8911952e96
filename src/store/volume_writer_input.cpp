// SPDX-License-Identifier: Apache-2.0
// The ways into a writer: frames, layers, or a field of the host.
#include <algorithm>
#include <cmath>
#include <span>

#include "fit/frame/box_overlap.h"
#include "formats/bcc4/sample_step.h"
#include "store/channel_info.h"
#include "store/site_planes.h"
#include "store/volume_writer.h"

namespace bccsplat {
namespace {

constexpr double share_of_data = 0.99; // of the progress; the rest is left for the tables

FieldGrid grid_of_frame(const std::array<uint32_t, 4>& dims, uint32_t frame) {
  return {{},
          {1, 1, 1},
          {static_cast<int32_t>(dims[0]), static_cast<int32_t>(dims[1]), static_cast<int32_t>(dims[2])},
          static_cast<double>(frame)};
}

// Are the values of a channel's codes those of the source, and exact as floats?
bool holds_source(const ChannelInfo& c) {
  const bool bytes = c.source_type == SourceType::u8 && c.type == ValueType::u8,
             words = c.source_type == SourceType::u16 && c.type == ValueType::u16;
  const float most = bytes ? UINT8_MAX : UINT16_MAX;
  const bool air_has_code = c.air >= 0 && c.air <= most && c.air == std::floor(c.air);
  return (bytes || words) && air_has_code && c.scale == 1 && c.offset == 0;
}

// May a stored value be off by just the bound, as of integers? Then rounding decides what is corrected, and a
// reader's own value has to be known: with a margin for it a bound of 3 would be one of 2.
bool meets_bound(const ChannelInfo& c, double bound) {
  constexpr double near = .01; // of a step
  const bool floats = c.source_type == SourceType::f16 || c.source_type == SourceType::f32 ||
                      c.source_type == SourceType::f64;
  const double steps = bound / c.scale;
  return bound > 0 && !floats && std::fabs(steps - std::nearbyint(steps)) < near;
}

// Is what is asked for so much that what a reader rounds (site_planes.h) is next to nothing beside it?
bool outweighs_rounding(const ChannelInfo& c, bool psnr, double bound) {
  const double rounded = exact_rounding * largest_code(c.type) * c.scale;
  return bound > 0 && !psnr ? bound >= 2 * rounded
                            : c.wavelet_error >= rounded && !(bound > 0 && bound < 2 * rounded);
}

} // namespace

void VolumeWriter::require_open() const {
  if (state_ == State::finished) fail(Code::wrong_state, "writer: finished already");
  if (state_ == State::failed) fail(Code::wrong_state, "writer: an earlier call failed; release it");
}

void VolumeWriter::require_input(Input input) const {
  if (input_ != Input::none && input_ != input)
    fail(Code::wrong_state, "writer: frames and layers do not mix");
}

bool VolumeWriter::is_refusal(Code code) {
  switch (code) {
  case Code::invalid_argument:
  case Code::wrong_state:
  case Code::unsupported:
  case Code::not_found:
  case Code::nonfinite_value:
  case Code::limit_exceeded:
    return true;
  default:
    return false;
  }
}

void VolumeWriter::unsettle(const Settled& settled) {
  fits_.clear();
  level_frames_.reset();
  input_ = Input::none;
  initial_ = settled.info, fit_options_ = settled.options;
}

void VolumeWriter::add_frame(uint32_t channel, double time, std::span<const FrameBox> boxes) {
  require_channel(channel);
  require_open();
  require_input(Input::frames);
  const uint64_t frame = added_[channel];
  check_time(frame, time);
  check_boxes(frame, boxes);
  const int index = channel;
  FrameScan scan;
  prepare([&] {
    begin_input(Input::frames, channel, boxes.empty() ? SourceType::f32 : boxes.front().type);
    scan = fit().check_frame(index, boxes);
    begin_measuring(true);
  });
  run_step([&] {
    if (frame == times_.size()) times_.push_back(time);
    now_.trigger = static_cast<uint32_t>(frame);
    for (const auto& level : fits_)
      measuring_.with_level(level->level(),
                            [&](RoundTrip& r) { r.add_frame(index, static_cast<uint32_t>(frame), boxes); });
    const PreparedFrame prepared = fit().prepare_frame(index, boxes, scan);
    if (fits_.size() > 1) { // what coarser levels are made of goes before level 0 takes its memory
      const LevelFrames::Images images =
          level_frames_->make(prepared, fit_options_.channels[channel].ringing);
      for (const auto& level : std::span(fits_).first(fits_.size() - 1))
        level->fit().add_frame(index, prepared, images.at(level->level()));
    }
    fit().add_frame(index, prepared, {prepared.frame, scan.cells, prepared.faces});
    ++added_[channel];
    show_if_due();
    const auto [first, end] = given_frames();
    if (end > 0) report_added(first, end);
    context_.progress.check();
  });
}

// Whether the writer may take layers, or a field.
void VolumeWriter::require_layers() const {
  if (fit_options_.part) fail(Code::unsupported, "a part of a series is made of frames");
  if (settings_.dims[3] == 0)
    fail(Code::wrong_state, "layers and fields need the number of frames: set dims[3]");
  require_input(Input::layers);
}

void VolumeWriter::add_layer(uint32_t channel, int64_t layer, std::span<const float> samples) {
  require_channel(channel);
  require_open();
  require_layers();
  if (layer != static_cast<int64_t>(added_[channel]))
    fail(Code::wrong_state, "layer ", layer, " given, ", added_[channel], " is next");
  if (layer >= initial_.lattice.layers())
    fail(Code::wrong_state, "layer ", layer, ": the series has ", initial_.lattice.layers(), " layers");
  const int index = channel;
  DirectLayerScan scan;
  prepare([&] {
    begin_input(Input::layers, channel, SourceType::f32);
    scan = fit().check_layer(index, samples);
    begin_measuring(false);
  });
  run_step([&] {
    fit().add_layer(index, samples, scan);
    ++added_[channel];
    show_if_due();
    report_added(0, fit().lattice().layers());
    context_.progress.check();
  });
}

void VolumeWriter::add_field(uint32_t channel, const Field& field) {
  require_channel(channel);
  require_open();
  require_layers();
  if (added_[channel] != 0) fail(Code::wrong_state, "channel ", channel, " has data already");
  prepare([&] {
    begin_input(Input::layers, channel, SourceType::f32);
    begin_measuring(true);
  });
  run_step([&] {
    const std::string what = concat("channel ", channel);
    const int32_t layers = fit().lattice().layers();
    size_t measured = 0;
    for (int32_t layer = 0; layer < layers; ++layer) {
      const FieldGrid sites = layer_geometry(layer).sites;
      // Frames are measured once the layers a little behind them are there.
      const auto due = [&] {
        const RoundTrip* const r = measuring_.round_trip();
        return r && measured < r->frames().size() && r->frames()[measured] <= sites.frame + 1;
      };
      for (; due(); ++measured) {
        const uint32_t frame = measuring_.round_trip()->frames()[measured];
        const std::vector<float> values =
            sample_field(field, grid_of_frame(settings_.dims, frame), what, context_);
        FrameBox box;
        box.data = values.data();
        box.dims = {settings_.dims[0], settings_.dims[1], settings_.dims[2]};
        measuring_.with_round_trip([&](RoundTrip& r) { r.add_frame(channel, frame, {&box, 1}); });
      }
      fit().add_layer(channel, sample_field(field, sites, what, context_));
      ++added_[channel];
      show_if_due();
      report_added(0, layers);
    }
  });
}

// Checks the time of a channel's next frame against those known.
void VolumeWriter::check_time(uint64_t frame, double time) const {
  if (!std::isfinite(time)) fail(Code::invalid_argument, "frame ", frame, ": the time is not finite");
  if (part_ && frame >= part_->fit.end_given)
    fail(Code::wrong_state, "frame ", frame, ": the part takes frames ", part_->fit.first_given, " to ",
         part_->fit.end_given - 1);
  if (settings_.dims[3] > 0 && frame >= settings_.dims[3])
    fail(Code::wrong_state, "frame ", frame, ": the writer was made for ", settings_.dims[3], " frames");
  if (frame < times_.size()) {
    if (times_[frame] != time)
      fail(Code::invalid_argument, "frame ", frame, ": time ", time, " differs from ", times_[frame],
           fit_options_.part ? " of the part's times" : " of another channel");
    return;
  }
  if (times_.empty()) return;
  if (!(time > times_.back()))
    fail(Code::invalid_argument, "frame ", frame, ": time ", time, " does not rise above ", times_.back(),
         " of the frame before");
  if (!std::isfinite(time - times_.front()))
    fail(Code::invalid_argument, "frame ", frame, ": time ", time, " is too far from ", times_.front(),
         " of frame 0");
}

void VolumeWriter::check_boxes(uint64_t frame, std::span<const FrameBox> boxes) const {
  for (size_t i = 0; i < boxes.size(); ++i)
    for (size_t a = 0; a < 3; ++a) {
      const int64_t n = settings_.dims[a], begin = boxes[i].begin[a], length = boxes[i].dims[a];
      if (begin < 0 || length < 1 || begin > n || length > n - begin)
        fail(Code::invalid_argument, "box ", i, " of frame ", frame, ": begin ", begin, " and dims ", length,
             " along axis ", a, " do not fit into 0 .. ", n);
    }
  if (const auto both = find_overlap(boxes))
    fail(Code::invalid_argument, "boxes ", (*both)[0], " and ", (*both)[1], " of frame ", frame, " overlap");
}

void VolumeWriter::require_wavelet_types() const {
  for (const ChannelInfo& c : initial_.channels)
    if (c.type != ValueType::u8 && c.type != ValueType::u16)
      fail(Code::invalid_argument, "channel ", c.name,
           ": wavelets are of samples stored as U8 or U16; give value_type U16 and the range of the values");
}

// Where a bound is kept by corrections, the error that is chosen for it is none that codes cannot keep.
void VolumeWriter::leave_rounding() {
  constexpr double of_code = .3; // more than the root of 1/12
  for (size_t c = 0; c < settings_.channels.size(); ++c) {
    const ChannelSettings& asked = settings_.channels[c];
    ChannelInfo& info = initial_.channels[c];
    if (asked.abs_error > 0 && asked.wavelet_error == 0)
      info.wavelet_error = std::max(info.wavelet_error, of_code * info.scale);
  }
}

// Settles, with the first data, how each channel is coded and what the fit has to do.
void VolumeWriter::begin_input(Input input, uint32_t first_channel, SourceType first_type) {
  if (!fits_.empty()) return;
  if (input == Input::layers && levels() > 0)
    fail(Code::unsupported,
         "writer: coarser levels are made of frames; layers and fields have level 0 alone");
  input_ = input;
  fit_options_.channels.clear();
  for (size_t c = 0; c < added_.size(); ++c)
    fit_options_.channels.push_back(code_channel(settings_.channels[c],
                                                 c == first_channel ? first_type : SourceType::f32,
                                                 settings_.coefficients, initial_.channels[c]));
  if (settings_.wavelets) require_wavelet_types(), leave_rounding();
  if (input == Input::frames && !continued_)
    fit_options_.lead = predicted_layers(), fit_options_.margins = outside_planes(frame_planes);
  if (input == Input::frames && (settings_.coefficients || settings_.wavelets))
    fit_options_.lasting_layers =
        fit_options_.slab_layers * lasting_slabs(lattice_of(fit_options_, settings_.dims[3]), fit_options_,
                                                 layer_use(), settings_.dims[3]);
  fit_options_.one_by_one = settings_.coefficients;
  begin_levels();
}

std::vector<FitOptions> VolumeWriter::level_options() const {
  std::vector<FitOptions> options{fit_options_};
  for (int level = 1; level <= levels(); ++level) {
    FitOptions& o =
        options.emplace_back(options_of_level(fit_options_, level, outside_planes(frame_planes, level)));
    if (part_) o.part->bricks = layer_bricks_of(part_->fit.counted, lattice_of(o, o.dims[3]), layer_use());
  }
  return options;
}

// Coarser levels come first, so that a coarse slab is one read. Level 0 prepares the frames of all, and tells
// what is missing before any of them takes a frame.
void VolumeWriter::begin_levels() {
  const auto store = [this](int32_t slab, const ChannelLevel& at, const SlabLayers& layers) {
    store_slab(slab, at, layers);
  };
  const MaskSink untold = [](int, uint32_t, const std::vector<std::byte>&) {};
  const MaskSink told = [this](int channel, uint32_t frame, std::vector<std::byte> runs) {
    take_mask(channel, frame, std::move(runs));
  };
  const int coarsest = levels();
  initial_.levels.resize(coarsest);
  const std::vector<FitOptions> options = level_options();
  level_frames_.emplace(options, context_);
  for (int level = coarsest; level >= 0; --level) {
    fits_.push_back(
        std::make_unique<LevelFit>(level, options[level], store, context_, level == 0 ? told : untold));
    if (settings_.coefficients) {
      std::optional<SeriesPart> part;
      if (part_made()) part = *part_made();
      if (part && level > 0) part->bricks = options[level].part->bricks.counted;
      fits_.back()->store_coefficients(initial_, part ? &*part : nullptr);
    }
    if (level == 0) break;
    LevelInfo& info = initial_.levels[static_cast<size_t>(level) - 1];
    info.lattice = fits_.back()->fit().lattice(), info.slab_layers = initial_.slab_layers;
    info.tile_edge = initial_.tile_edge;
    for (const ChannelInfo& c : initial_.channels)
      info.channels.push_back({.scale = c.scale, .kept_range = {}});
  }
}

// The frames that are measured: of the series, of a part, or of those that continue a file as far as all the
// layers they depend on are made.
std::vector<uint32_t> VolumeWriter::frames_to_measure() const {
  const uint32_t frames = settings_.dims[3];
  if (continued_) {
    const SeriesPart& rest = continued_->rest();
    std::vector<uint32_t> list = measuring_.choose_frames(rest.fit.counted.first_frame(), frames);
    std::erase_if(list, [&](uint32_t f) {
      return layers_to_measure(fit().lattice(), initial_.recommended_kernel, settings_.coefficients, f)
                 .begin < rest.first_layer;
    });
    return list;
  }
  return own_frames(measuring_.choose_frames(0, frames));
}

std::vector<uint32_t> VolumeWriter::own_frames(std::vector<uint32_t> list) const {
  if (part_) std::erase_if(list, [&](uint32_t f) { return !part_->fit.counted.has_frame(f); });
  return list;
}

// Called when the fit has begun. frames_known: the source samples of frames will be given.
void VolumeWriter::begin_measuring(bool frames_known) {
  if (!measuring_.due()) return;
  if (!frames_known || settings_.dims[3] == 0) {
    if (measuring_.required())
      fail(Code::wrong_state,
           "writer: layers alone do not tell the source samples that a bound or measuring needs; "
           "give frames or a field");
    return;
  }
  std::vector<RoundTripChannel> channels;
  bool at_sites = settings_.wavelets && measuring_.required();
  for (size_t i = 0; i < initial_.channels.size(); ++i) {
    ChannelInfo& c = initial_.channels[i];
    const double bound = settings_.channels[i].abs_error;
    channels.push_back({c.name, settings_.channels[i].air, c.threshold, bound, knows_base(),
                        bound > 0 ? 0 : sample_step(c)});
    at_sites = at_sites && (settings_.psnr > 0 || !meets_bound(c, bound)) &&
               outweighs_rounding(c, settings_.psnr > 0, bound);
    if (holds_source(c)) channels.back().as_given = c.source_type;
    if (bound == 0) continue;
    c.residuals.step = RoundTrip::step(bound), c.residuals.bound = bound;
    c.residuals.local = true, c.residuals.shape = CorrectionShape::smooth;
  }
  const SeriesPart* const part = part_made();
  std::vector<uint32_t> frames = frames_to_measure();
  measuring_.attempt([&] {
    measuring_.begin(std::make_unique<RoundTrip>(
        fit().lattice(), std::move(channels), initial_.recommended_kernel, settings_.coefficients,
        std::move(frames),
        [this](int channel, uint32_t frame, const FrameResiduals& residuals) {
          store_residuals(channel, frame, residuals);
        },
        context_,
        RoundTripScope{.first_layer = part ? part->first_layer : 0,
                       .in_boxes = !measuring_.required(),
                       .at_sites = at_sites,
                       .samples = is_block() ? scope_of(fit_options_, fit().lattice()).counted : Region{},
                       .bricks = is_block() ? part_->measured : BrickBox{}}));
  });
  begin_measuring_levels();
}

// The frames that continue a file know too little of the earlier ones: what was measured of these stays. With
// fixed predictions the file is that of blocks, which know too little of coarser levels.
void VolumeWriter::begin_measuring_levels() {
  if (continued_ || settings_.fixed_predictions || !measuring_.round_trip()) return;
  const std::vector<uint32_t> frames = own_frames(measuring_.choose_level_frames(0, settings_.dims[3]));
  for (int level = 1; level <= static_cast<int>(initial_.levels.size()); ++level) {
    std::vector<RoundTripChannel> channels;
    for (size_t i = 0; i < initial_.channels.size(); ++i) {
      const ChannelInfo& c = initial_.channels[i];
      channels.push_back({c.name, settings_.channels[i].air, c.threshold, 0, knows_base(), sample_step(c)});
    }
    // Samples between those of the level, in all places relative to them.
    const int32_t every = (1 << level) + 1;
    measuring_.begin_level(level, [&] {
      return std::make_unique<RoundTrip>(initial_.levels[static_cast<size_t>(level) - 1].lattice, channels,
                                         initial_.recommended_kernel, settings_.coefficients, frames, nullptr,
                                         context_,
                                         RoundTripScope{.first_layer = part_ ? part_->first_layer : 0,
                                                        .every = every,
                                                        .in_boxes = !measuring_.required()});
    });
  }
}

// first, end: of the frames or layers that a channel is given.
void VolumeWriter::report_added(uint64_t first, uint64_t end) {
  const uint64_t added = *std::min_element(added_.begin(), added_.end());
  context_.progress.report(share_of_data * static_cast<double>(added - first) /
                           static_cast<double>(end - first));
}

} // namespace bccsplat
