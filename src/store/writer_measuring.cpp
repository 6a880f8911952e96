// SPDX-License-Identifier: Apache-2.0
// How the comparison with the source begins: which frames take part, and what their samples are compared
// with.
#include "store/writer_input.h"

#include <algorithm>
#include <cmath>

#include "formats/bcc4/encode/encode_tile.h"
#include "formats/bcc4/sample_step.h"
#include "store/site_planes.h"

namespace bccsplat {
namespace {

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
  return bound > 0 && !floats && !c.linear && std::fabs(steps - std::nearbyint(steps)) < near;
}

// Is what is asked for so much that what a reader rounds (site_planes.h) is next to nothing beside it?
bool outweighs_rounding(const ChannelInfo& c, bool psnr, double bound) {
  const double rounded = exact_rounding * largest_code(c.type) * c.scale;
  return bound > 0 && !psnr ? bound >= 2 * rounded
                            : c.wavelet_error >= rounded && !(bound > 0 && bound < 2 * rounded);
}

// Returns whether what is stored of the samples is compared, not the field that goes through them: labels are
// read so, and of wavelets it is as good.
bool compares_at_sites(const WriterOpening& opening) {
  const WriterSettings& s = opening.settings();
  const VolumeInfo& info = opening.info();
  const auto labels = [](const ChannelSettings& c) { return c.labels.value_or(false); };
  if (std::all_of(s.channels.begin(), s.channels.end(), labels)) return !opening.is_block();
  for (size_t i = 0; i < info.channels.size(); ++i) {
    const double bound = s.channels[i].abs_error;
    if ((s.psnr == 0 && meets_bound(info.channels[i], bound)) ||
        !outweighs_rounding(info.channels[i], s.psnr > 0, bound))
      return false;
  }
  return s.wavelets && s.must_measure();
}

// The channels as they are compared; of coarser levels nothing is bounded.
std::vector<RoundTripChannel> channels_to_measure(const WriterOpening& opening, bool coarser) {
  std::vector<RoundTripChannel> channels;
  for (size_t i = 0; i < opening.info().channels.size(); ++i) {
    const ChannelInfo& c = opening.info().channels[i];
    const ChannelSettings& asked = opening.settings().channels[i];
    const double bound = coarser ? 0 : asked.abs_error;
    channels.push_back(
        {c.name, asked.air, c.threshold, bound, opening.knows_base(), bound > 0 ? 0 : sample_step(c)});
    if (!coarser && opening.settings().wavelets && holds_source(c)) channels.back().as_given = c.source_type;
    if (c.linear) channels.back().read_off = (as_read_rounding + linear_rounding) / 2 * c.scale;
  }
  return channels;
}

// Keeps those frames of the list that the writer is given and counts; of those that continue a file as far as
// all the layers they depend on are made.
std::vector<uint32_t> own_frames(const WriterOpening& opening, const Lattice4& lattice,
                                 std::vector<uint32_t> list) {
  const SeriesPart* const part = opening.part_made();
  std::erase_if(list, [&](uint32_t f) {
    if (!part) return false;
    if (!opening.continued()) return !part->fit.counted.has_frame(f);
    return layers_to_measure(lattice, opening.info().recommended_kernel, f).begin < part->fit.first_layer;
  });
  return list;
}

} // namespace

void WriterInput::begin_measuring(bool frames_known) {
  if (!measuring_.due()) return;
  if (!frames_known || opening_.frames() == 0) {
    if (measuring_.required())
      fail(Code::wrong_state,
           "writer: layers alone do not tell the source samples that a bound or measuring needs; "
           "give frames or a field");
    return;
  }
  const SeriesPart* const part = opening_.part_made();
  const Lattice4& lattice = fits_.lattice();
  const uint32_t first = opening_.continued() ? part->fit.counted.first_frame() : 0;
  std::vector<uint32_t> frames =
      own_frames(opening_, lattice, measuring_.choose_frames(first, opening_.frames()));
  const auto store = [this](int channel, uint32_t frame, const FrameResiduals& residuals) {
    output_.store_residuals(channel, frame, residuals);
  };
  const bool at_sites = compares_at_sites(opening_);
  measuring_.begin(0, [&] {
    return std::make_unique<RoundTrip>(
        lattice, channels_to_measure(opening_, false), opening_.info().recommended_kernel, std::move(frames),
        store, context_,
        RoundTripScope{.first_layer = part ? part->fit.first_layer : 0,
                       .in_boxes = !measuring_.required() && !at_sites,
                       .at_sites = at_sites,
                       .samples = opening_.is_block() ? scope_of(opening_.fit(), lattice).counted : Region{},
                       .bricks = opening_.is_block() ? part->measured : BrickBox{}});
  });
  begin_measuring_levels();
}

// The frames that continue a file know too little of the earlier ones: what was measured of these stays. With
// fixed predictions the file is that of blocks, which know too little of coarser levels.
void WriterInput::begin_measuring_levels() {
  if (opening_.continued() || opening_.settings().fixed_predictions || !measuring_.round_trip()) return;
  const SeriesPart* const part = opening_.part();
  const std::vector<uint32_t> frames =
      own_frames(opening_, fits_.lattice(), measuring_.choose_level_frames(0, opening_.frames()));
  for (int level = 1; level <= fits_.coarsest(); ++level) {
    // Samples between those of the level, in all places relative to them.
    const int32_t every = (1 << level) + 1;
    measuring_.begin(level, [&] {
      return std::make_unique<RoundTrip>(fits_.lattice(level), channels_to_measure(opening_, true),
                                         opening_.info().recommended_kernel, frames, nullptr, context_,
                                         RoundTripScope{.first_layer = part ? part->fit.first_layer : 0,
                                                        .every = every,
                                                        .in_boxes = !measuring_.required()});
    });
  }
}

} // namespace bccsplat
