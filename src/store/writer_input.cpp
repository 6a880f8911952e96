// SPDX-License-Identifier: Apache-2.0
// Checks times, boxes and the order of layers before the first data settle anything, and hands what has
// passed to the fits.
#include "store/writer_input.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "fit/frame/box_overlap.h"
#include "fit/frame/unpack.h"
#include "formats/bcc4/labels_attribute.h"

namespace bccsplat {

namespace {

// Returns whether a sample is above `limit`, which floats alone do not tell, or with sign -1 below it.
bool passes(std::span<const FrameBox> boxes, const std::array<int64_t, 3>& dims, double limit, float sign) {
  const Frame from_limit(boxes, dims, limit, "frame");
  std::vector<float> row(dims[0]);
  for (int64_t z = 0; z < dims[2]; ++z)
    for (int64_t y = 0; y < dims[1]; ++y) {
      const Region region{{0, y, z}, {dims[0], y + 1, z + 1}};
      from_limit.read(from_limit.boxes_in(region), region, row.data(), dims[0], dims[0]);
      if (std::any_of(row.begin(), row.end(), [&](float v) { return v * sign > 0; })) return true;
    }
  return false;
}

} // namespace

WriterInput::WriterInput(WriterOpening& opening, LevelFits& fits, Measuring& measuring, WriterOutput& output,
                         const Context& context)
    : opening_(opening), fits_(fits), measuring_(measuring), output_(output), context_(context) {
  const auto& part = opening.fit().part;
  given_.added.assign(opening.settings().channels.size(), part ? part->first_given : 0);
  if (part) given_.times = opening.settings().part->times;
}

FrameScan WriterInput::check_frame(uint32_t channel, double time, std::span<const FrameBox> boxes) {
  require_kind(GivenData::Kind::frames);
  check_time(given_.added[channel], time);
  check_boxes(given_.added[channel], boxes);
  const SourceType type = boxes.empty() ? SourceType::f32 : boxes.front().type;
  return check_settled(GivenData::Kind::frames, channel, type, [&] {
    FrameScan scan = fits_.fit().check_frame(static_cast<int>(channel), boxes);
    require_exact_labels(channel, boxes, scan);
    begin_measuring(true);
    return scan;
  });
}

void WriterInput::require_exact_labels(uint32_t channel, std::span<const FrameBox> boxes,
                                       const FrameScan& scan) const {
  const ChannelSettings& c = opening_.settings().channels[channel];
  const bool wide =
      std::any_of(boxes.begin(), boxes.end(), [](const FrameBox& box) { return wider_than_float(box.type); });
  if (!wide || !c.labels.value_or(said_labels(opening_.info(), c.name).value_or(false))) return;
  constexpr double exact = 1 << 24; // whole numbers up to this are, as floats
  const auto& n = opening_.settings().dims;
  const std::array<int64_t, 3> dims{n[0], n[1], n[2]};
  for (const double from : {0.0, c.air})
    if ((scan.high - from >= exact && passes(boxes, dims, from + exact, 1)) ||
        (scan.low - from <= -exact && passes(boxes, dims, from - exact, -1)))
      fail(Code::limit_exceeded, "channel ", c.name, ": labels of frame ", given_.added[channel],
           " are further than 16777216 from ", from,
           ", and come back exactly up to there: number them anew, such as 0, 1, 2 ...");
}

void WriterInput::add_frame(uint32_t channel, double time, std::span<const FrameBox> boxes,
                            const FrameScan& scan) {
  const auto index = static_cast<int>(channel);
  const auto frame = static_cast<uint32_t>(given_.added[channel]);
  if (frame == given_.times.size()) given_.times.push_back(time);
  output_.begin_turn(frame);
  for (int level = fits_.coarsest(); level >= 0; --level)
    measuring_.with_level(level, [&](RoundTrip& r) { r.add_frame(index, frame, boxes); });
  fits_.add_frame(index, boxes, scan, opening_.fit().channels[channel].ringing);
  finish_step(channel);
}

DirectLayerScan WriterInput::check_layer(uint32_t channel, int64_t layer, std::span<const float> samples) {
  require_layers();
  if (layer != static_cast<int64_t>(given_.added[channel]))
    fail(Code::wrong_state, "layer ", layer, " given, ", given_.added[channel], " is next");
  if (const int32_t layers = opening_.info().lattice.layers(); layer >= layers)
    fail(Code::wrong_state, "layer ", layer, ": the series has ", layers, " layers");
  return check_settled(GivenData::Kind::layers, channel, SourceType::f32, [&] {
    DirectLayerScan scan = fits_.fit().check_layer(static_cast<int>(channel), samples);
    begin_measuring(false);
    return scan;
  });
}

void WriterInput::add_layer(uint32_t channel, std::span<const float> samples, const DirectLayerScan& scan) {
  fits_.fit().add_layer(static_cast<int>(channel), samples, scan);
  finish_step(channel);
}

void WriterInput::check_field(uint32_t channel) {
  require_layers();
  if (given_.added[channel] != 0) fail(Code::wrong_state, "channel ", channel, " has data already");
  check_settled(GivenData::Kind::layers, channel, SourceType::f32, [&] { begin_measuring(true); });
}

void WriterInput::add_field(uint32_t channel, const Field& field) {
  const std::string what = concat("channel ", channel);
  size_t measured = 0;
  for (int32_t layer = 0; layer < fits_.lattice().layers(); ++layer) {
    const FieldGrid sites = grid_of_layer(opening_.info().lattice, layer);
    // Frames are measured once the layers a little behind them are there.
    const auto due = [&] {
      const RoundTrip* const r = measuring_.round_trip();
      return r && measured < r->frames().size() && r->frames()[measured] <= sites.frame + 1;
    };
    for (; due(); ++measured) {
      const uint32_t frame = measuring_.round_trip()->frames()[measured];
      const FieldGrid grid = grid_of_frame(fits_.lattice(), frame);
      const std::vector<float> values = sample_field(field, grid, what, context_);
      FrameBox box;
      box.data = values.data();
      box.dims = {grid.dims[0], grid.dims[1], grid.dims[2]};
      measuring_.with_level(0, [&](RoundTrip& r) {
        r.add_frame(static_cast<int>(channel), frame, {&box, 1});
      });
    }
    fits_.fit().add_layer(static_cast<int>(channel), sample_field(field, sites, what, context_));
    finish_step(channel);
  }
}

void WriterInput::begin(GivenData::Kind kind, uint32_t first_channel, SourceType first_type) {
  opening_.settle(kind == GivenData::Kind::frames, first_channel, first_type);
  given_.kind = kind;
  const auto store = [this](int32_t slab, const ChannelLevel& at, const SlabLayers& layers) {
    output_.store_slab(slab, at, layers);
  };
  const auto take_mask = [this](int channel, uint32_t frame, std::vector<std::byte> runs) {
    output_.take_mask(channel, frame, std::move(runs));
  };
  fits_.begin(opening_.level_options(), store, take_mask, context_);
}

void WriterInput::require_kind(GivenData::Kind kind) const {
  if (given_.kind != GivenData::Kind::none && given_.kind != kind)
    fail(Code::wrong_state, "writer: frames and layers do not mix");
}

void WriterInput::require_layers() const {
  if (opening_.fit().part) fail(Code::unsupported, "a part of a series is made of frames");
  if (opening_.frames() == 0)
    fail(Code::wrong_state, "layers and fields need the number of frames: set dims[3]");
  require_kind(GivenData::Kind::layers);
}

// Checks the time of a channel's next frame against those known.
void WriterInput::check_time(uint64_t frame, double time) const {
  const std::vector<double>& times = given_.times;
  if (!std::isfinite(time)) fail(Code::invalid_argument, "frame ", frame, ": the time is not finite");
  if (const SeriesPart* const part = opening_.part(); part && frame >= part->fit.end_given)
    fail(Code::wrong_state, "frame ", frame, ": the part takes frames ", part->fit.first_given, " to ",
         part->fit.end_given - 1);
  if (opening_.frames() > 0 && frame >= opening_.frames())
    fail(Code::wrong_state, "frame ", frame, ": the writer was made for ", opening_.frames(), " frames");
  if (frame < times.size()) {
    if (times[frame] != time)
      fail(Code::invalid_argument, "frame ", frame, ": time ", time, " differs from ", times[frame],
           opening_.fit().part ? " of the part's times" : " of another channel");
    return;
  }
  if (times.empty()) return;
  if (!(time > times.back()))
    fail(Code::invalid_argument, "frame ", frame, ": time ", time, " does not rise above ", times.back(),
         " of the frame before");
  if (!std::isfinite(time - times.front()))
    fail(Code::invalid_argument, "frame ", frame, ": time ", time, " is too far from ", times.front(),
         " of frame 0");
}

void WriterInput::check_boxes(uint64_t frame, std::span<const FrameBox> boxes) const {
  for (size_t i = 0; i < boxes.size(); ++i)
    for (size_t a = 0; a < 3; ++a) {
      const int64_t n = opening_.settings().dims[a], begin = boxes[i].begin[a], length = boxes[i].dims[a];
      if (begin < 0 || length < 1 || begin > n || length > n - begin)
        fail(Code::invalid_argument, "box ", i, " of frame ", frame, ": begin ", begin, " and dims ", length,
             " along axis ", a, " do not fit into 0 .. ", n);
    }
  if (const auto both = find_overlap(boxes))
    fail(Code::invalid_argument, "boxes ", (*both)[0], " and ", (*both)[1], " of frame ", frame, " overlap");
}

// Counts a frame or layer that a channel was given.
void WriterInput::finish_step(uint32_t channel) {
  constexpr double share_of_data = 0.99; // of the progress; the rest is left for the tables
  ++given_.added[channel];
  output_.show_if_due(given_);
  const auto& part = opening_.fit().part;
  const uint64_t first = part ? part->first_given : 0;
  const uint64_t frames = part ? part->end_given : opening_.frames();
  const uint64_t end = given_.has_frames() ? frames : fits_.lattice().layers();
  if (end == 0) return context_.progress.check();
  context_.progress.report(share_of_data * static_cast<double>(given_.least() - first) /
                           static_cast<double>(end - first));
}

} // namespace bccsplat
