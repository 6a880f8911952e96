// SPDX-License-Identifier: Apache-2.0
// Checks the options of a plan by the writer's own rules and a few of its own, and describes the series to
// src/choose as a reader of files would. Frames are copied once, into the memory that a reader keeps.
#include "plan/host_series.h"

#include <algorithm>
#include <cmath>

#include "api/numbers.h"
#include "api/structs.h"
#include "api/writer.h"
#include "base/machine.h"
#include "kernel/kernel.h"

namespace bccsplat::plan {
namespace {

using namespace bccsplat::api;

constexpr double most_density = 4; // sites per source sample

[[noreturn]] void refuse(const char* field, const char* why) {
  fail(Code::unsupported, "bccsplat_plan_options.wish.", field, ": ", why);
}

// What a plan finds by itself, or leaves to the writer.
void require_whole(const bccsplat_writer_options& w) {
  if (w.part) refuse("part", "a plan is made of the whole series; set part in the options that it gives");
  if (w.partial == BCCSPLAT_PARTIAL_APPEND)
    refuse("partial", "a series that goes on keeps the coding of its file; give its options to the writer");
  if (w.wavelet_errors) refuse("wavelet_errors", "the plan finds them by abs_error or psnr");
  if (w.abs_errors) refuse("abs_errors", "the plan finds them by the range of each channel");
}

// The channel of a wish, which may name none.
bccsplat_channel_options channel_of(const bccsplat_writer_options& w, uint32_t c) {
  return read_struct(w.channel_count > 0 ? element(w.channels, c) : nullptr, "bccsplat_channel_options");
}

series::Channel read_channel(const bccsplat_channel_options& own, const bccsplat_plan_channel& in,
                             uint32_t c) {
  const std::string name = concat("bccsplat_plan_options.channels[", c, "]");
  require_choice(in.type, BCCSPLAT_TYPE_U32, (name + ".type").c_str());
  require_zero(in.reserved, (name + ".reserved").c_str());
  require_number(in.step, (name + ".step").c_str());
  require_number(in.offset, (name + ".offset").c_str());
  if ((own.set_mask & BCCSPLAT_CHANNEL_SET_RANGE) != 0 || own.value_step != 0)
    refuse("channels", "the plan finds range and value_step; leave them out");
  series::Channel channel;
  if (own.name) channel.name = own.name;
  if (own.unit) channel.unit = own.unit;
  channel.type = series::type_of(in.type);
  channel.precision =
      own.source_type == BCCSPLAT_TYPE_DEFAULT ? channel.type : series::type_of(own.source_type);
  channel.has_fill = in.missing != 0;
  channel.step = in.step, channel.offset = in.offset;
  if (own.set_mask & BCCSPLAT_CHANNEL_SET_AIR) channel.air = own.air;
  if (own.set_mask & BCCSPLAT_CHANNEL_LABELS) channel.labels = true;
  if (own.set_mask & BCCSPLAT_CHANNEL_QUANTITIES) channel.labels = false;
  return channel;
}

void read_channels(const bccsplat_plan_options& o, const bccsplat_writer_options& w, Request& out) {
  const bccsplat_channel_options first = channel_of(w, 0);
  out.settings.quantize = first.value_type, out.settings.air_threshold = first.air_threshold;
  bool one_air = true;
  for (uint32_t c = 0; c < std::max(w.channel_count, 1u); ++c) {
    const bccsplat_channel_options own = channel_of(w, c);
    if (own.value_type != first.value_type || own.air_threshold != first.air_threshold)
      refuse("channels", "all channels of a plan have one value_type and one air_threshold");
    const bool said = (own.set_mask & BCCSPLAT_CHANNEL_SET_AIR) != 0;
    one_air = one_air && said && own.air == first.air;
    out.series.channels.push_back(read_channel(
        own, read_struct(o.channels ? element(o.channels, c) : nullptr, "bccsplat_plan_channel"), c));
    if (said) out.wish.own_air.insert(out.series.channels.back().name);
  }
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
  s.files.push_back({"the series", 0}); // as errors name it
}

void read_settings(const bccsplat_writer_options& w, series::WriterSettings& s) {
  s.lattice = w.lattice, s.filter = w.filter, s.lowpass = w.lowpass != 0;
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
  out.wish.memory = machine_memory() / 2;
}

} // namespace

Request read_request(const bccsplat_plan_options& o, const bccsplat_writer_options& w) {
  if ((o.set_mask & ~uint32_t{BCCSPLAT_PLAN_SET_LEVELS}) != 0)
    fail(Code::invalid_argument, "bccsplat_plan_options.set_mask: unknown bits ", o.set_mask);
  require_zero(o.reserved, "bccsplat_plan_options.reserved");
  require_whole(w);
  (void)read_writer_settings(w, nullptr); // refuses what the writer would
  if (w.recommended_kernel) (void)make_kernel(w.recommended_kernel);
  Request out;
  read_series(o, w, out.series);
  read_settings(w, out.settings);
  read_channels(o, w, out);
  read_wish(o, w, out);
  return out;
}

series::Frame HostFrames::read(uint64_t frame, size_t channel) {
  const auto& n = series_.dims;
  const series::Type type = series_.channels[channel].type;
  series::Box box{{{}, {n[0], n[1], n[2]}}, type, nullptr, {}};
  const uint64_t size = series::type_size(type);
  auto bytes = std::make_shared<series::Bytes>(box.samples() * size);
  if (frame_(user_, frame, static_cast<uint32_t>(channel), bytes->data()) != 0)
    fail(Code::cancelled, "the host gave no frame ", frame, " of channel ", channel);
  box.data = bytes->data(), box.stride_bytes = {size, size * n[0], size * n[0] * n[1]};
  return {{box}, {std::move(bytes)}};
}

std::string HostFrames::frame_name(uint64_t frame) const { return concat("frame ", frame); }

} // namespace bccsplat::plan
