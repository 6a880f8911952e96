// SPDX-License-Identifier: Apache-2.0
// Opens a volume whose bytes the page fetches, and tells what it holds.
#include <emscripten.h>

#include <array>

#include "json.h"
#include "viewer.h"

// Copies bytes that the page has into the module's memory; returns how many, or that they are on their way.
EM_JS(double, host_read, (double offset, void* buffer, double size),
      { return Module["readAt"](offset, buffer, size); });

EM_JS(void, web_write_number, (double value, char* text), { stringToUTF8(String(value), text, 64); })

namespace web {

Viewer viewer;

void note_error() { viewer.text = bccsplat_last_error(); }

int answer(void (*body)(const void*), const void* of) {
  try {
    body(of);
    return BCCSPLAT_OK;
  } catch (const Error& e) {
    note_error();
    return e.status();
  } catch (const std::exception& e) {
    viewer.text = e.what();
    return BCCSPLAT_ERROR_INTERNAL;
  }
}

namespace {

constexpr uint64_t merge_gap = 256 << 10; // what a request costs more than these bytes do

int64_t read_at(void* /*user*/, uint64_t offset, void* buffer, uint64_t size) {
  return static_cast<int64_t>(host_read(static_cast<double>(offset), buffer, static_cast<double>(size)));
}

std::string channel_text(uint32_t channel) {
  auto info = sized<bccsplat_channel_info>();
  check(bccsplat_volume_get_channel_info(viewer.volume.get(), channel, &info));
  return Object()
      .add("name", info.name)
      .add("unit", info.unit)
      .add("air", info.air)
      .add("labels", static_cast<double>(info.labels))
      .put("range", json(std::span<const double>(info.range)))
      .put("keptRange", json(std::span<const double>(info.kept_range)))
      .put("histogram", json(std::span<const uint64_t>(info.histogram)))
      .text();
}

std::string times_text() {
  std::vector<double> times(viewer.info.dims[3]);
  check(bccsplat_volume_get_times(viewer.volume.get(), times.data(), times.size(), nullptr));
  return json(std::span<const double>(times));
}

std::string axis_text(uint32_t a) {
  const bccsplat_axis& axis = viewer.axes[a];
  return Object()
      .put("places", json(std::span(axis.coordinates, static_cast<size_t>(axis.count))))
      .add("down", (axis.flags & BCCSPLAT_AXIS_DOWN) != 0 ? 1.0 : 0.0)
      .add("unit", axis.unit)
      .text();
}

// The texts of the first so many, as a list.
std::string list(uint32_t count, std::string (*text)(uint32_t)) {
  std::string out = "[";
  for (uint32_t n = 0; n < count; ++n) out += (n > 0 ? "," : "") + text(n);
  return out + "]";
}

std::string info_text() {
  const bccsplat_volume_info& i = viewer.info;
  const std::array<double, 3> across{samples_across(i, 0), samples_across(i, 1), samples_across(i, 2)};
  return Object()
      .put("dims", json(std::span<const uint64_t>(i.dims)))
      .put("across", json(std::span<const double>(across)))
      .put("affine", json(std::span<const double>(i.affine)))
      .put("axes", list(3, axis_text))
      .put("times", times_text())
      .add("timeEnd", i.time_end)
      .add("voxel", i.mean_voxel)
      .add("spatialUnit", i.spatial_unit)
      .add("timeUnit", i.time_unit)
      .add("levels", static_cast<double>(i.level_count))
      .add("bytes", static_cast<double>(i.bytes_file))
      .put("channels", list(i.channel_count, channel_text))
      .text();
}

} // namespace

void Viewer::open(double bytes) {
  *this = Viewer();
  auto device_options = sized<bccsplat_device_options>();
  constexpr uint64_t budget = uint64_t{1536} << 20; // of the 2 GiB that a module may have
  device_options.thread_count = 1, device_options.memory_budget = budget;
  device = make(bccsplat_device_create, &device_options);
  auto stream = sized<bccsplat_read_stream>();
  stream.size = static_cast<uint64_t>(bytes), stream.read_at = read_at, stream.merge_gap = merge_gap;
  volume = make(bccsplat_volume_open_stream, device.get(), &stream, nullptr);
  info = sized<bccsplat_volume_info>();
  check(bccsplat_volume_get_info(volume.get(), &info));
  for (uint32_t a = 0; a < 3; ++a)
    axes[a] = sized<bccsplat_axis>(), check(bccsplat_volume_get_axis(volume.get(), a, &axes[a]));
  renderer = make(bccsplat_renderer_create, device.get());
}

} // namespace web

using namespace web;

extern "C" {

// Opens a stream of so many bytes; the text is what it holds.
EMSCRIPTEN_KEEPALIVE int web_open(double bytes) {
  return answer([&] {
    viewer.open(bytes);
    viewer.text = info_text();
  });
}

EMSCRIPTEN_KEEPALIVE const char* web_text() { return viewer.text.c_str(); }

// What the last call lacked: pairs of offset and size; returns their number.
EMSCRIPTEN_KEEPALIVE int web_lacking(double* pairs, int capacity) {
  std::vector<uint64_t> ranges(2 * static_cast<size_t>(capacity));
  uint64_t count = 0;
  if (bccsplat_last_lacking(ranges.data(), static_cast<uint64_t>(capacity), &count) != BCCSPLAT_OK) return 0;
  const auto known = static_cast<size_t>(std::min<uint64_t>(count, static_cast<uint64_t>(capacity)));
  for (size_t n = 0; n < 2 * known; ++n) pairs[n] = static_cast<double>(ranges[n]);
  return static_cast<int>(known);
}

} // extern "C"
