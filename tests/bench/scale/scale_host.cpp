// SPDX-License-Identifier: Apache-2.0
// Wraps calls of the C API that throw, and makes the puffs: one block of samples, handed over eight times a
// frame as boxes that move.
#include "tests/bench/scale/scale_host.h"

#include <cmath>
#include <vector>

#include <fcntl.h>
#include <unistd.h>

#include "base/error.h"

namespace bccsplat::bench {
namespace {

using host::sized;

// One puff in a cube of `size` samples: dense in the middle, with folds that need the lattice's resolution.
std::vector<uint8_t> puff(int64_t size) {
  std::vector<uint8_t> values(static_cast<size_t>(size * size * size));
  const double centre = 0.5 * static_cast<double>(size - 1);
  size_t i = 0;
  for (int64_t z = 0; z < size; ++z)
    for (int64_t y = 0; y < size; ++y)
      for (int64_t x = 0; x < size; ++x) {
        const double u = (static_cast<double>(x) - centre) / centre,
                     v = (static_cast<double>(y) - centre) / centre,
                     w = (static_cast<double>(z) - centre) / centre;
        const double r = std::sqrt(u * u + v * v + w * w);
        const double folds = 1 + 0.4 * std::sin(9 * u + 4 * v) * std::cos(8 * w - 3 * u);
        values[i++] =
            static_cast<uint8_t>(r < 1 ? std::lround(170 * (1 - r) * (1 - r) * (1 + 2 * r) * folds) : 0);
      }
  return values;
}

} // namespace

void api(bccsplat_status status) {
  if (status != BCCSPLAT_OK) fail(static_cast<Code>(status), bccsplat_last_error());
}

Handle<bccsplat_device> make_api_device(int threads) {
  auto options = sized<bccsplat_device_options>();
  options.thread_count = threads;
  bccsplat_device* device = nullptr;
  api(bccsplat_device_create(&options, &device));
  return Handle<bccsplat_device>(device);
}

bccsplat_writer_report write_puffs(bccsplat_device* device, const Puffs& p, const std::string& path) {
  auto options = sized<bccsplat_writer_options>();
  for (int a = 0; a < 3; ++a) options.dims[a] = p.n;
  options.dims[3] = p.frames;
  options.overwrite = 1;
  bccsplat_writer* w = nullptr;
  api(bccsplat_writer_create(device, path.c_str(), &options, &w));
  const Handle<bccsplat_writer> writer(w);
  const int64_t size = 3 * p.n / 8, half = p.n / 2, room = half - size;
  const std::vector<uint8_t> values = puff(size);
  for (uint32_t f = 0; f < p.frames; ++f) {
    bccsplat_box boxes[8];
    for (int64_t octant = 0; octant < 8; ++octant) {
      bccsplat_box& box = boxes[octant] = sized<bccsplat_box>();
      box.type = BCCSPLAT_TYPE_U8;
      box.data = values.data();
      for (int a = 0; a < 3; ++a) {
        // There and back along each axis, at speeds that differ by octant and axis.
        const double phase = 0.11 * f * (1 + 0.3 * a) + 0.8 * static_cast<double>(octant);
        box.begin[a] =
            (octant >> a & 1) * half + std::llround(0.5 * static_cast<double>(room) * (1 + std::sin(phase)));
        box.dims[a] = size;
      }
    }
    api(bccsplat_writer_add_frame(w, 0, f, boxes, 8));
  }
  auto report = sized<bccsplat_writer_report>();
  api(bccsplat_writer_finish(w, &report));
  return report;
}

Handle<bccsplat_volume> open_puffs(bccsplat_device* device, const std::string& path) {
  bccsplat_volume* volume = nullptr;
  api(bccsplat_volume_open_file(device, path.c_str(), nullptr, &volume));
  return Handle<bccsplat_volume>(volume);
}

Handle<bccsplat_slice> slice_puffs(const bccsplat_volume* volume, double frame) {
  auto plane = sized<bccsplat_hyperplane>();
  plane.d = 1;
  plane.e = -frame;
  bccsplat_slice* slice = nullptr;
  api(bccsplat_slice_create(volume, &plane, nullptr, &slice));
  return Handle<bccsplat_slice>(slice);
}

bccsplat_render_stats draw_puffs(bccsplat_device* device, const bccsplat_slice* slice, uint32_t size) {
  bccsplat_renderer* r = nullptr;
  api(bccsplat_renderer_create(device, &r));
  const Handle<bccsplat_renderer> renderer(r);
  const double colors[] = {0, 0.9, 0.8, 0.7, 255, 1, 1, 1}, opacities[] = {10, 0, 200, 0.3};
  auto function = sized<bccsplat_transfer_function>();
  function.colors = colors, function.color_count = 2;
  function.opacities = opacities, function.opacity_count = 2;
  api(bccsplat_renderer_set_slice(r, slice));
  api(bccsplat_renderer_set_transfer_function(r, &function));
  bccsplat_frame* f = nullptr;
  api(bccsplat_frame_create(device, size, size, BCCSPLAT_FRAME_RGBA, &f));
  const Handle<bccsplat_frame> frame(f);
  api(bccsplat_renderer_render(r, f));
  auto stats = sized<bccsplat_render_stats>();
  api(bccsplat_renderer_get_stats(r, &stats));
  return stats;
}

bccsplat_volume_info info_of(const bccsplat_volume* volume) {
  auto info = sized<bccsplat_volume_info>();
  api(bccsplat_volume_get_info(volume, &info));
  return info;
}

bccsplat_slice_info info_of(const bccsplat_slice* slice) {
  auto info = sized<bccsplat_slice_info>();
  api(bccsplat_slice_get_info(slice, &info));
  return info;
}

void forget_pages(const std::string& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) fail(Code::io_error, path);
  const bool synced = ::fsync(file) == 0; // only clean pages are dropped
  const int dropped = ::posix_fadvise(file, 0, 0, POSIX_FADV_DONTNEED);
  ::close(file);
  if (!synced || dropped != 0) fail(Code::io_error, path, ": its cached pages stay");
}

uint64_t peak_of(const bccsplat_device* device) {
  auto info = sized<bccsplat_device_info>();
  api(bccsplat_device_get_info(device, &info));
  return info.memory_peak;
}

} // namespace bccsplat::bench
