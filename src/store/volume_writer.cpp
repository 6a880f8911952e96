// SPDX-License-Identifier: Apache-2.0
// Which calls may follow which: data are checked, then taken; what fails on the way ends the writer.
#include "store/volume_writer.h"

#include <algorithm>
#include <utility>

#include "base/error.h"
#include "formats/bcc4/labels_attribute.h"

namespace bccsplat {
namespace {

bool is_refusal(Code code) {
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

} // namespace

VolumeWriter::VolumeWriter(WriterSettings settings, std::unique_ptr<ByteSink> stream, const Context& context)
    : context_(context), measuring_(settings),
      opening_(std::move(settings), stream != nullptr, measuring_, context),
      output_(opening_, fits_, measuring_, std::move(stream), context),
      input_(opening_, fits_, measuring_, output_, context),
      ending_(opening_, fits_, measuring_, output_, input_.given(), context) {}

template<class Check> auto VolumeWriter::check(const Check& step) {
  try {
    return step();
  } catch (const Error& e) {
    if (!is_refusal(e.code())) state_ = State::failed;
    throw;
  } catch (...) {
    state_ = State::failed;
    throw;
  }
}

template<class Step> void VolumeWriter::run_step(const Step& step) {
  state_ = State::failed;
  step();
  state_ = State::open;
}

void VolumeWriter::require_open() const {
  if (state_ == State::finished) fail(Code::wrong_state, "writer: finished already");
  if (state_ == State::failed) fail(Code::wrong_state, "writer: an earlier call failed; release it");
}

void VolumeWriter::require_open(uint32_t channel) const {
  require_channel(channel);
  require_open();
}

void VolumeWriter::add_frame(uint32_t channel, double time, std::span<const FrameBox> boxes) {
  require_open(channel);
  const FrameScan scan = check([&] { return input_.check_frame(channel, time, boxes); });
  run_step([&] { input_.add_frame(channel, time, boxes, scan); });
}

void VolumeWriter::add_layer(uint32_t channel, int64_t layer, std::span<const float> samples) {
  require_open(channel);
  const DirectLayerScan scan = check([&] { return input_.check_layer(channel, layer, samples); });
  run_step([&] { input_.add_layer(channel, samples, scan); });
}

void VolumeWriter::add_field(uint32_t channel, const Field& field) {
  require_open(channel);
  check([&] { input_.check_field(channel); });
  run_step([&] { input_.add_field(channel, field); });
}

WriteReport VolumeWriter::finish_short() {
  require_open();
  if (const auto frames = ending_.fewer_frames()) run_step([&] { ending_.shorten(*frames); });
  return finish();
}

WriteReport VolumeWriter::finish() {
  require_open();
  ending_.check();
  WriteReport report;
  run_step([&] { report = ending_.finish(); });
  state_ = State::finished;
  try {
    context_.progress.report(1);
  } catch (const Error&) {
    // Too late to cancel: the file has its name.
  }
  return report;
}

void VolumeWriter::set_times(double first, double step) {
  require_open();
  if (input_.given().has_frames()) fail(Code::wrong_state, "set_times: frames are given with their times");
  opening_.info().time.first = first, opening_.info().time.step = step;
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
  auto& attributes = opening_.info().attributes;
  const auto it =
      std::find_if(attributes.begin(), attributes.end(), [&](const auto& a) { return a.first == key; });
  for (const ChannelInfo& c : opening_.info().channels)
    if (key == labels_attribute(c.name) && (it == attributes.end() || it->second != value))
      fail(Code::invalid_argument, "attribute ", key,
           ": the options of the channel say whether it has labels");
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
  opening_.info().sources.push_back(std::move(source));
}

void VolumeWriter::require_channel(uint32_t channel) const {
  const size_t channels = opening_.info().channels.size();
  if (channel >= channels) fail(Code::not_found, "channel ", channel, " of a writer with ", channels);
}

LayerGeometry VolumeWriter::layer_geometry(int64_t number) const {
  if (opening_.frames() == 0) fail(Code::wrong_state, "layers need the number of frames: set dims[3]");
  const Lattice4& lattice = opening_.info().lattice;
  if (number < 0 || number >= lattice.layers())
    fail(Code::not_found, "layer ", number, " of ", lattice.layers());
  const auto layer = static_cast<int32_t>(number);
  return {lattice.coset(layer), grid_of_layer(lattice, layer), lattice.layers()};
}

std::array<uint64_t, 2> VolumeWriter::given_frames() const {
  const auto& part = opening_.fit().part;
  return {part ? part->first_given : 0, part ? part->end_given : opening_.frames()};
}

Region VolumeWriter::given_samples() const {
  if (opening_.is_block()) return scope_of(opening_.fit(), opening_.info().lattice).given;
  const auto& dims = opening_.settings().dims;
  return {{}, {dims[0], dims[1], dims[2]}};
}

MeasuredErrors VolumeWriter::measured(uint32_t channel, int64_t index) const {
  require_channel(channel);
  if (state_ != State::finished) fail(Code::wrong_state, "writer: errors are known after finish");
  return ending_.measured(channel, index);
}

} // namespace bccsplat
