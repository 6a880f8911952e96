// SPDX-License-Identifier: Apache-2.0
// Checks the options of a plan by the writer's own rules and a few of its own, and describes the series to
// src/choose as a reader of files would. Frames are copied once, into the memory that a reader keeps.
#include "plan/host_series.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "api/numbers.h"
#include "api/structs.h"
#include "api/writer.h"
#include "base/machine.h"
#include "kernel/kernel.h"

namespace bccsplat::plan {
namespace {

using namespace bccsplat::api;

constexpr double most_density = 4; // sites per source sample
constexpr uint32_t kinds = uint32_t{BCCSPLAT_CHANNEL_LABELS} | BCCSPLAT_CHANNEL_QUANTITIES;

[[noreturn]] void refuse(const char* field, const char* why) {
  fail(Code::unsupported, "bccsplat_plan_options.wish.", field, ": ", why);
}

// The channel of a wish, which may name none.
bccsplat_channel_options channel_of(const bccsplat_writer_options& w, uint32_t c) {
  return read_struct(w.channel_count > 0 ? element(w.channels, c) : nullptr, "bccsplat_channel_options");
}

uint32_t kind_of(const bccsplat_channel_options& own) { return own.set_mask & kinds; }

void require_kind(uint32_t kind, const std::string& channel) {
  if ((kind & ~kinds) != 0 || kind == kinds)
    fail(Code::invalid_argument, channel, ".kind is ", kind, ", not that of labels or of quantities");
}

series::Channel read_channel(const bccsplat_channel_options& own, const bccsplat_plan_channel& in,
                             uint32_t frames, uint32_t c) {
  const std::string name = concat("bccsplat_plan_options.channels[", c, "]");
  require_choice(in.type, BCCSPLAT_TYPE_U32, (name + ".type").c_str());
  require_kind(in.kind, name);
  require_number(in.step, (name + ".step").c_str());
  require_number(in.offset, (name + ".offset").c_str());
  if ((own.set_mask & BCCSPLAT_CHANNEL_SET_RANGE) != 0 && own.value_step == 0)
    refuse("channels", "the plan finds range; leave it out, or give value_step, too");
  series::Channel channel;
  if (own.name) channel.name = own.name;
  if (own.unit) channel.unit = own.unit;
  channel.type = series::type_of(in.type);
  channel.precision =
      own.source_type == BCCSPLAT_TYPE_DEFAULT ? channel.type : series::type_of(own.source_type);
  channel.has_fill = in.missing != 0;
  channel.step = in.step, channel.offset = in.offset;
  if (own.set_mask & BCCSPLAT_CHANNEL_SET_AIR) channel.air = own.air;
  if (const uint32_t kind = kind_of(own) | in.kind) channel.labels = (kind & BCCSPLAT_CHANNEL_LABELS) != 0;
  if (in.active) channel.active.assign(in.active, in.active + frames);
  return channel;
}

void read_channels(const bccsplat_plan_options& o, const bccsplat_writer_options& w, Request& out) {
  const bccsplat_channel_options first = channel_of(w, 0);
  const uint32_t count = std::max(w.channel_count, 1u);
  out.settings.air_threshold = first.air_threshold;
  std::optional<bccsplat_type> type; // of channels without a step
  bool one_air = true, steps = false;
  for (uint32_t c = 0; c < count; ++c) {
    const bccsplat_channel_options own = channel_of(w, c);
    const bool has_step = own.value_step > 0;
    if ((!has_step && type.value_or(own.value_type) != own.value_type) ||
        own.air_threshold != first.air_threshold)
      refuse("channels", "all channels of a plan have one value_type and one air_threshold");
    if (!has_step) type = own.value_type;
    const bool said = (own.set_mask & BCCSPLAT_CHANNEL_SET_AIR) != 0;
    one_air = one_air && said && own.air == first.air;
    out.series.channels.push_back(
        read_channel(own, read_struct(o.channels ? element(o.channels, c) : nullptr, "bccsplat_plan_channel"),
                     w.dims[3], c));
    if (said) out.wish.own_air.insert(out.series.channels.back().name);
    out.wish.kinds.push_back(kind_of(own));
    out.settings.steps.push_back(has_step ? series::StepCoding{own.value_step, {own.range[0], own.range[1]}}
                                          : series::StepCoding{});
    steps = steps || has_step;
  }
  out.settings.quantize = type.value_or(BCCSPLAT_TYPE_DEFAULT);
  if (!steps) out.settings.steps.clear();
  if (w.wavelet_errors) out.settings.wavelet_errors.assign(w.wavelet_errors, w.wavelet_errors + count);
  if (w.abs_errors) out.settings.abs_errors.assign(w.abs_errors, w.abs_errors + count);
  if (one_air) out.settings.air = first.air;
}

void read_places(const bccsplat_writer_options& w, series::SeriesDescription& s) {
  for (size_t a = 0; w.axes && a < s.places.size(); ++a) {
    const auto axis = read_struct(element(w.axes, a), "bccsplat_axis");
    if (axis.unit) s.places[a].unit = axis.unit;
    s.places[a].down = (axis.flags & BCCSPLAT_AXIS_DOWN) != 0;
    if (axis.count > 0) s.places[a].coordinates.assign(axis.coordinates, axis.coordinates + axis.count);
  }
}

void read_times(const double* times, uint32_t frames, series::SeriesTimes& out) {
  for (uint32_t f = 0; f < frames; ++f) out.values.push_back(times ? times[f] : f);
  for (size_t f = 0; f < out.values.size(); ++f) {
    require_number(out.values[f], "bccsplat_plan_options.times");
    if (f > 0 && !(out.values[f] > out.values[f - 1]))
      fail(Code::invalid_argument, "bccsplat_plan_options.times: that of frame ", f, ", ", out.values[f],
           ", is not after the one before; times rise");
  }
}

void read_series(const bccsplat_plan_options& o, const bccsplat_writer_options& w,
                 series::SeriesDescription& s) {
  std::copy(std::begin(w.dims), std::end(w.dims), s.dims.begin());
  for (const uint64_t n : s.dims)
    if (n == 0)
      fail(Code::invalid_argument, "bccsplat_plan_options.wish.dims: all four are counts from 1 on");
  if (std::any_of(std::begin(w.affine), std::end(w.affine), [](double v) { return v != 0; }))
    std::copy(std::begin(w.affine), std::end(w.affine), s.affine.begin());
  read_places(w, s);
  if (w.spatial_unit) s.spatial_unit = w.spatial_unit;
  if (w.time_unit) s.times.unit = w.time_unit;
  read_times(o.times, w.dims[3], s.times);
  s.files.push_back({o.name ? o.name : "the series", 0}); // as errors name it
}

void read_settings(const bccsplat_writer_options& w, series::WriterSettings& s) {
  s.lattice = w.lattice, s.lowpass = w.lowpass != 0;
  s.ends = w.ends, s.faces = w.faces, s.periodic = static_cast<int32_t>(w.periodic_axes);
  s.store = w.store, s.nonfinite = w.nonfinite;
  s.scale = w.scale, s.time_scale = w.time_scale;
  std::copy(std::begin(w.scales), std::end(w.scales), s.scales.begin());
  s.measure = w.measure == BCCSPLAT_MEASURE_DEFAULT ? BCCSPLAT_MEASURE_SOME : w.measure;
  if (w.recommended_kernel) s.kernel = w.recommended_kernel;
  s.fixed_predictions = w.fixed_predictions != 0;
  s.overwrite = w.overwrite != 0, s.partial = w.partial, s.live = w.live;
  s.cancel_token = w.cancel_token;
}

void read_wish(const bccsplat_plan_options& o, const bccsplat_writer_options& w, Request& out) {
  if (w.abs_error > 0 && w.psnr > 0)
    fail(Code::invalid_argument, "bccsplat_plan_options.wish: abs_error and psnr; a plan keeps one of them");
  require_zero_or(o.density, smallest_length, most_density, "bccsplat_plan_options.density");
  if (o.density > 0 && series::has_distances(out.settings))
    fail(
        Code::invalid_argument,
        "bccsplat_plan_options.density chooses the distances that wish.scale, time_scale or scales give; one "
        "or the other");
  out.wish.bound = series::usual_bound({w.abs_error, w.psnr}, w.store);
  if (o.set_mask & BCCSPLAT_PLAN_SET_LEVELS) out.wish.levels = w.levels;
  out.wish.density = o.density, out.wish.exact = o.exact != 0;
  out.wish.auto_time_scale = (o.set_mask & BCCSPLAT_PLAN_AUTO_TIME_SCALE) != 0;
  out.wish.everything = (o.set_mask & BCCSPLAT_PLAN_EVERYTHING) != 0;
  const uint64_t all = machine_memory();
  out.wish.memory = o.memory > 0 ? o.memory : all > 0 ? all / 2 : UINT64_MAX;
}

} // namespace

Request read_request(const bccsplat_plan_options& o, const bccsplat_writer_options& w) {
  constexpr uint32_t known = 2 * BCCSPLAT_PLAN_LARGE_FRAMES - 1;
  if ((o.set_mask & ~known) != 0)
    fail(Code::invalid_argument, "bccsplat_plan_options.set_mask: unknown bits ", o.set_mask);
  require_zero(o.reserved, "bccsplat_plan_options.reserved");
  if ((o.set_mask & BCCSPLAT_PLAN_LARGE_FRAMES) != 0 && !o.boxes)
    fail(Code::invalid_argument, "bccsplat_plan_options.boxes is NULL, and LARGE_FRAMES asks it for parts");
  if (w.part) refuse("part", "a plan is made of the whole series; set part in the options that it gives");
  (void)read_writer_settings(w, nullptr); // refuses what the writer would
  if (w.recommended_kernel) (void)make_kernel(w.recommended_kernel);
  Request out;
  read_series(o, w, out.series);
  read_settings(w, out.settings);
  read_channels(o, w, out);
  read_wish(o, w, out);
  return out;
}

namespace {

// A box of the host's as readers have it; without strides it is packed.
series::Box box_of(const bccsplat_box& in, const std::array<uint64_t, 4>& dims) {
  const auto refuse_box = [](const char* why) {
    fail(Code::invalid_argument, "bccsplat_plan_options.boxes gave a box ", why);
  };
  if (in.type < BCCSPLAT_TYPE_U8 || in.type > BCCSPLAT_TYPE_U32) refuse_box("of no type of values");
  if (!in.data) refuse_box("without data");
  series::Box box{{}, series::type_of(in.type), static_cast<const std::byte*>(in.data), {}};
  bool packed = true;
  for (size_t a = 0; a < 3; ++a) {
    const auto n = static_cast<int64_t>(dims[a]);
    if (in.begin[a] < 0 || in.dims[a] < 1 || in.dims[a] > n || in.begin[a] > n - in.dims[a])
      refuse_box("that is empty, or not within the frame");
    box.begin[a] = static_cast<uint64_t>(in.begin[a]), box.dims[a] = static_cast<uint64_t>(in.dims[a]);
    box.stride_bytes[a] = static_cast<uint64_t>(in.stride_bytes[a]);
    packed = packed && in.stride_bytes[a] == 0;
  }
  const uint64_t size = series::type_size(box.type);
  if (packed) box.stride_bytes = {size, size * box.dims[0], size * box.dims[0] * box.dims[1]};
  return box;
}

} // namespace

series::Frame HostFrames::read(uint64_t frame, size_t channel) {
  const auto& n = series_.dims;
  if (options_.boxes) return read_box(frame, channel, {{}, {n[0], n[1], n[2]}});
  const series::Type type = series_.channels[channel].type;
  series::Box box{{{}, {n[0], n[1], n[2]}}, type, nullptr, {}};
  const uint64_t size = series::type_size(type);
  auto bytes = std::make_shared<series::Bytes>(box.samples() * size);
  if (options_.frame(options_.frame_user, frame, static_cast<uint32_t>(channel), bytes->data()) != 0)
    give_up(frame, channel);
  box.data = bytes->data(), box.stride_bytes = {size, size * n[0], size * n[0] * n[1]};
  return {{box}, {std::move(bytes)}};
}

series::Frame HostFrames::read_box(uint64_t frame, size_t channel, const series::SampleBox& wanted) {
  if (!options_.boxes) return read(frame, channel);
  auto given = series::sized<bccsplat_source_boxes>();
  std::array<uint64_t, 3> end{};
  for (size_t a = 0; a < 3; ++a) end[a] = wanted.begin[a] + wanted.dims[a];
  if (options_.boxes(options_.frame_user, frame, static_cast<uint32_t>(channel), wanted.begin.data(),
                     end.data(), &given) != 0)
    give_up(frame, channel);
  series::Frame out;
  if (given.release) // with the last who has the frame
    out.storage.emplace_back(new series::Bytes, [release = given.release, keeper = given.keeper](auto* none) {
      delete none;
      release(keeper);
    });
  if (given.count > 0) require(given.boxes, "boxes");
  for (uint64_t i = 0; i < given.count; ++i)
    out.boxes.push_back(box_of(read_struct(element(given.boxes, i), "bccsplat_box"), series_.dims));
  return out;
}

void HostFrames::give_up(uint64_t frame, size_t channel) const {
  fail(Code::cancelled, "the host gave no frame ", frame, " of channel ", channel);
}

std::string HostFrames::frame_name(uint64_t frame) const { return concat("frame ", frame); }

} // namespace bccsplat::plan
