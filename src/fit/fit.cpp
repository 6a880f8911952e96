// SPDX-License-Identifier: Apache-2.0
// Begins and ends a fit: checks what is asked for, says which lattice it is, and reports what was counted.
#include "fit/fit.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/sizes.h"
#include "fit/fit_state.h"

namespace bccsplat {
namespace {

constexpr uint64_t largest_layer = 16 << 20; // bricks: 4096^3 sites

// Refuses what no reader would open either, before tables are made for it.
Lattice4 checked(const Lattice4& lattice) {
  uint64_t bricks = 1;
  for (const int32_t n : lattice.space.dims(0)) bricks = checked_mul(bricks, (n - 1) / brick_edge + 1);
  if (bricks > largest_layer)
    fail(Code::limit_exceeded, "a layer of ", bricks, " bricks of 16^3 sites is more than ", largest_layer,
         "; divide the volume or use a coarser lattice");
  return lattice;
}

void check_options(const FitOptions& options) {
  if (options.channels.empty()) fail(Code::invalid_argument, "there is no channel");
  if (options.lead < 0 || options.lead % 2 != 0)
    fail(Code::invalid_argument, options.lead, " layers before the first frame; an even number is needed");
  if (options.slab_layers < 1) fail(Code::invalid_argument, "a slab has at least one layer");
  if (options.periodic && (options.dims[3] < 2 || options.lead > 0 || options.part))
    fail(Code::invalid_argument,
         "ends: a periodic series needs the number of its frames, at least 2, and has ",
         "neither layers beyond its ends nor parts");
}

LayerCounts counts_of(const LayerMaker& maker, uint64_t sites_total) {
  SiteCounts counts = maker.counts();
  return {sites_total, counts.sites.kept, counts.sites.holes, counts.sites.clamped,
          std::move(counts.samples)};
}

} // namespace

Lattice4 lattice_of(const FitOptions& options, uint32_t frames) {
  return Lattice4::fit(options.lattice, {options.dims[0], options.dims[1], options.dims[2], frames},
                       options.scales, options.lead, options.margins, options.periodic, options.turning);
}

Lattice4 lattice_over(const std::array<int64_t, 3>& dims, Lattice4 lattice) {
  for (size_t a = 0; a < 3; ++a) {
    if (dims[a] == int64_t{lattice.dims[a]}) continue;
    const double was = lattice.domain_end(a);
    lattice.dims[a] = static_cast<uint32_t>(dims[a]);
    lattice.space_step[a] *= lattice.domain_end(a) / was;
  }
  return lattice;
}

Region seen_samples(const FitOptions& options, const Lattice4& lattice, const std::array<int64_t, 3>& dims) {
  const SpatialResampler resampler(lattice_over(dims, lattice));
  const BrickBox bricks = options.part ? options.part->bricks.made : BrickBox{};
  const Region seen = resampler.seen_by(resampler.whole_tiles(bricks));
  return seen.empty() ? Region{} : whole_cells(seen, dims);
}

FitScope scope_of(const FitOptions& options, const Lattice4& lattice) {
  const std::array<int64_t, 3> n{options.dims[0], options.dims[1], options.dims[2]};
  FitScope scope{{{}, n}, {{}, n}, {{}, n}};
  if (!options.part || options.part->counted.all_space()) return scope;
  const SeriesBlock& block = options.part->counted;
  for (size_t a = 0; a < 3; ++a)
    scope.counted.begin[a] = block.begin[a], scope.counted.end[a] = std::min<int64_t>(block.end[a], n[a]);
  // Cells are scanned as wholes: their ranges are those of the frame's only where all of their samples come.
  scope.seen =
      whole_cells(scope.counted, n).joined(seen_samples(options, lattice, n)).joined(options.part->halved);
  scope.given = scope.seen;
  if (!options.fill.bounded()) return scope;
  const int64_t reach = std::max(options.fill.samples(), options.part->masked), cell = options.fill.cell();
  for (size_t a = 0; a < 3; ++a) {
    scope.given.begin[a] = std::max<int64_t>(scope.seen.begin[a] - reach, 0) / cell * cell;
    scope.given.end[a] = std::min((scope.seen.end[a] + reach + cell - 1) / cell * cell, n[a]);
  }
  scope.given = whole_cells(scope.given, n);
  return scope;
}

std::array<int64_t, 3> mask_reach_of(const FitOptions& options, const Lattice4& lattice) {
  std::array<int64_t, 3> reach;
  for (size_t a = 0; a < 3; ++a)
    reach[a] = static_cast<int64_t>(std::ceil(options.mask_reach * lattice.space_step[a] + 0.5));
  return reach;
}

uint64_t Fit::State::counted_sites(int coset) const {
  if (!is_block()) return lattice.space.sites(coset);
  const Int3 n = lattice.space.dims(coset);
  const BrickBox& box = options.part->bricks.counted;
  uint64_t sites = 1;
  for (size_t a = 0; a < 3; ++a)
    sites *= std::max(0, std::min(box.end[a] * brick_edge, n[a]) - box.begin[a] * brick_edge);
  return sites;
}

double time_widening(const Lattice4& lattice) {
  return lattice.is_static() ? 1 : std::max(1.0, lattice.time_step / lattice.layer_distance());
}

void LayerCounts::add(const LayerCounts& other) {
  sites_total += other.sites_total, sites_kept += other.sites_kept;
  holes += other.holes, clamped += other.clamped;
  samples.merge(other.samples);
}

Fit::State::State(const FitOptions& o, FitSink s, const Context& c, MaskSink m)
    : options(o), sink(std::move(s)), mask_sink(std::move(m)), context(c), pool(c.memory),
      lattice(checked(lattice_of(o, o.dims[3] > 0 ? o.dims[3] : 2))), scope(scope_of(o, lattice)),
      ends(time_widening(lattice), o.lead) {
  check_options(options);
  if (options.periodic) begin_turn();
  for (const FitChannel& channel : options.channels) {
    channels.push_back(std::make_unique<Channel>(static_cast<int>(channels.size()), channel));
    if (options.part) begin_part(*channels.back(), *options.part);
    if (options.lowpass) channels.back()->lowpass = std::make_unique<Lowpass>(lattice, channel.ringing);
    if (options.periodic) begin_turn(*channels.back());
  }
}

void Fit::State::begin_part(Channel& c, const FitPart& part) const {
  c.given = c.frames = c.window_first = part.first_given;
  c.next_layer = part.first_layer;
  c.slab_index = part.first_layer / options.slab_layers;
}

Fit::State::Channel& Fit::State::channel(int index) const {
  if (index < 0 || static_cast<size_t>(index) >= channels.size())
    fail(Code::invalid_argument, "there is no channel ", index);
  return *channels[index];
}

void Fit::State::shorten(uint32_t frames) {
  options.dims[3] = lattice.dims[3] = frames;
  if (layers_given)
    lattice.last_layer = channels.front()->next_layer - 1;
  else
    lattice = lattice_of(options, frames);
}

uint32_t Fit::State::frames_given() const {
  return options.dims[3] > 0 ? options.dims[3] : channels.front()->given;
}

void Fit::State::check_end() const {
  for (const auto& c : channels) {
    if (layers_given) {
      if (c->next_layer != lattice.layers())
        fail(Code::wrong_state, "channel '", c->options.name, "' was given ", c->next_layer, " of its ",
             lattice.layers(), " layers");
      continue;
    }
    const uint32_t end = options.part ? options.part->end_given : frames_given();
    if (end == 0) fail(Code::wrong_state, "no frame was given");
    if (c->given != end)
      fail(Code::wrong_state, "channel '", c->options.name, "' was given ", c->given, " frames, not ", end);
  }
}

void Fit::State::end() {
  const uint32_t frames = frames_given();
  // A low-pass whose frames had no known end.
  if (!options.part && !layers_given)
    for (const auto& c : channels) finish_lowpass(*c);
  if (!layers_given) lattice = lattice_of(options, frames);
  finished = true;
}

void Fit::State::finish_channel(int index) {
  Channel& c = channel(index);
  // A part has made its layers by now, unless it ends with the series.
  const bool more = !options.part || options.part->end_given == lattice.dims[3];
  if (!layers_given && more) make_layers(c);
  if (c.next_layer != end_layer())
    fail(Code::internal, "layer ", c.next_layer, " of ", end_layer(), " could not be made");
  hand_out(c);
  c.window.clear();
}

FitReport Fit::State::report() const {
  FitReport report{lattice, {}};
  for (const auto& channel : channels) {
    const Channel& c = *channel;
    FitChannelReport& r = report.channels.emplace_back(c.report);
    r.lasting = counts_of(c.lasting, c.report.lasting.sites_total);
    static_cast<LayerCounts&>(r) = counts_of(c.maker, c.report.sites_total);
    r.add(r.lasting);
    const CodingError &first = c.lasting.coding_error(), &coding = c.maker.coding_error();
    r.coding_max = std::max(first.largest, coding.largest);
    if (r.sites_total > 0)
      r.coding_rmse = std::sqrt((first.squares + coding.squares) / static_cast<double>(r.sites_total));
  }
  return report;
}

Fit::Fit(const FitOptions& options, FitSink sink, const Context& context, MaskSink masks)
    : state_(std::make_unique<State>(options, std::move(sink), context, std::move(masks))) {}

Fit::~Fit() = default;

FrameScan Fit::check_frame(int channel, std::span<const FrameBox> boxes) const {
  return state_->check_frame(channel, boxes);
}

PreparedFrame Fit::prepare_frame(int channel, std::span<const FrameBox> boxes, const FrameScan& scan) {
  return state_->prepare_frame(channel, boxes, scan);
}

void Fit::add_frame(int channel, const PreparedFrame& frame, const FrameImage& image) {
  state_->add_frame(channel, frame, image);
}

DirectLayerScan Fit::check_layer(int channel, std::span<const float> samples) const {
  return state_->check_layer(channel, samples);
}

void Fit::add_layer(int channel, std::span<const float> samples, const DirectLayerScan& scan) {
  state_->add_layer(channel, samples, scan);
}

bool Fit::has_begun() const {
  return std::any_of(state_->channels.begin(), state_->channels.end(),
                     [](const auto& c) { return c->next_layer > 0; });
}

void Fit::shorten(uint32_t frames) { state_->shorten(frames); }

void Fit::check_end() const { state_->check_end(); }

void Fit::end() { state_->end(); }

void Fit::finish_channel(int channel) { state_->finish_channel(channel); }

FitReport Fit::report() const { return state_->report(); }

FitReport Fit::finish() {
  check_end();
  end();
  for (size_t c = 0; c < state_->channels.size(); ++c) finish_channel(static_cast<int>(c));
  return report();
}

const Lattice4& Fit::lattice() const { return state_->lattice; }

} // namespace bccsplat
