// SPDX-License-Identifier: Apache-2.0
// Stores a source in memory through the C API, opens it, and draws it by its own look or by the function and
// options of a shot; also the values of its field.
#include "tests/bench/pictures/picture_volume.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#ifdef BCCSPLAT_BENCH_READERS
#include "tool/view/xray_exposure.h"
#endif

namespace bccsplat::bench {
namespace {

using host::sized;

// Of a voxel, as bcc4 render --range has it.
constexpr double ramp_begin = 0.02, ramp_opacity = 0.25;

int64_t write_bytes(void* user, uint64_t offset, const void* data, uint64_t size) {
  auto& bytes = *static_cast<std::vector<unsigned char>*>(user);
  if (bytes.size() < offset + size) bytes.resize(offset + size);
  std::memcpy(bytes.data() + offset, data, size);
  return size;
}

std::vector<unsigned char> written(bccsplat_device* device, const FitSource& source, uint32_t levels) {
  std::vector<unsigned char> file;
  auto stream = sized<bccsplat_write_stream>();
  stream.write_at = write_bytes, stream.user = &file;
  auto options = sized<bccsplat_writer_options>();
  std::copy(source.dims.begin(), source.dims.end(), options.dims);
  options.dims[3] = 1, options.levels = levels;
  bccsplat_writer* w = nullptr;
  api(bccsplat_writer_create_stream(device, &stream, &options, &w));
  const Handle<bccsplat_writer> writer(w);
  auto box = sized<bccsplat_box>();
  box.type = source.type == SourceType::u8 ? BCCSPLAT_TYPE_U8 : BCCSPLAT_TYPE_F32;
  box.data = source.bytes.data();
  for (size_t a = 0; a < 3; ++a) box.dims[a] = source.dims[a];
  api(bccsplat_writer_add_frame(w, 0, 0, &box, 1));
  api(bccsplat_writer_finish(w, nullptr));
  return file;
}

Handle<bccsplat_slice> sliced(const bccsplat_volume* volume, const std::array<uint32_t, 4>& dims,
                              const Shot& shot) {
  auto plane = sized<bccsplat_hyperplane>();
  plane.d = 1;
  const double box[6] = {0, 0, 0, dims[0] - 1.0, dims[1] - 1.0, shot.cut.value_or(dims[2] - 1.0)};
  auto options = sized<bccsplat_slice_options>();
  if (shot.cut) options.box = box;
  options.level = shot.level;
  bccsplat_slice* slice = nullptr;
  api(bccsplat_slice_create(volume, &plane, &options, &slice));
  return Handle<bccsplat_slice>(slice);
}

// World space is index space.
bccsplat_camera front_camera(const std::array<uint32_t, 4>& dims, const Shot& shot) {
  auto camera = sized<bccsplat_camera>();
  camera.projection = shot.perspective ? BCCSPLAT_PROJECTION_PERSPECTIVE : BCCSPLAT_PROJECTION_ORTHOGRAPHIC;
  for (int a = 0; a < 3; ++a) camera.position[a] = camera.target[a] = 0.5 * (dims[a] - 1.0);
  camera.position[2] = 2.0 * dims[2];
  camera.up[1] = 1;
  camera.ortho_height = dims[1];
  const double distance = camera.position[2] - shot.cut.value_or(dims[2] - 1.0);
  camera.fovy_degrees = 360 / std::numbers::pi * std::atan(0.5 * dims[1] / distance);
  return camera;
}

} // namespace

double Body::outside(double x, double y, double z) const {
  const double c = 0.5 * (n - 1.0), dx = std::fabs(x - c), dy = std::fabs(y - c), dz = std::fabs(z - c);
  return (ball ? std::hypot(dx, dy, dz) : std::max({dx, dy, dz})) - radius();
}

FitSource Body::source() const {
  FitSeries s{{n, n, n, 1}, {}};
  for (uint32_t z = 0; z < n; ++z)
    for (uint32_t y = 0; y < n; ++y)
      for (uint32_t x = 0; x < n; ++x) {
        const double d = outside(x, y, z);
        const double share = edge > 0 ? std::clamp(0.5 - d / edge, 0.0, 1.0) : d < 0 ? 1.0 : 0.0;
        s.values.push_back(static_cast<float>(inside * share));
      }
  return type == SourceType::u8 ? source_of<uint8_t>(s, type, 1, "") : source_of<float>(s, type, 1, "");
}

PictureVolume::PictureVolume(bccsplat_device* device, const FitSource& source, uint32_t levels)
    : device_(device), dims_(source.dims), file_(written(device, source, levels)) {
  bccsplat_volume* volume = nullptr;
  api(bccsplat_volume_open_memory(device, file_.data(), file_.size(), nullptr, &volume));
  volume_.reset(volume);
}

Drawn PictureVolume::draw(const Shot& shot) const {
  const Handle<bccsplat_slice> slice = sliced(volume_.get(), dims_, shot);
  bccsplat_renderer* r = nullptr;
  api(bccsplat_renderer_create(device_, &r));
  const Handle<bccsplat_renderer> renderer(r);
  api(bccsplat_renderer_set_slice(r, slice.get()));
  Drawn out;
  out.width = shot.from_front ? static_cast<int>(shot.pixels * dims_[0]) : 512;
  out.height = shot.from_front ? static_cast<int>(shot.pixels * dims_[1]) : 512;
  const bccsplat_camera camera = front_camera(dims_, shot);
  if (shot.from_front) api(bccsplat_renderer_set_camera(r, &camera));
  if (shot.white || shot.ramp != 0) {
    const double colors[] = {shot.middle, 0.8, 0.8, 0.8},
                 step[] = {0.75 * shot.middle, 0, 1.25 * shot.middle, shot.white.value_or(0)},
                 ramp[] = {ramp_begin * shot.ramp, 0, shot.ramp, ramp_opacity};
    const double* const opacities = shot.ramp != 0 ? ramp : step;
    auto function = sized<bccsplat_transfer_function>();
    function.colors = colors, function.color_count = 1;
    function.opacities = opacities, function.opacity_count = 2;
    api(bccsplat_renderer_set_transfer_function(r, &function));
  }
  auto options = sized<bccsplat_render_options>();
  options.quality = shot.quality, options.mode = shot.mode;
  if (shot.any_gradient) options.set_mask = BCCSPLAT_RENDER_SET_GRADIENT_NOISE;
  if (shot.mode == BCCSPLAT_MODE_ISOSURFACE)
    options.iso_value = look().iso_value, options.set_mask |= BCCSPLAT_RENDER_SET_ISO;
  api(bccsplat_renderer_set_options(r, &options));
  out.rgba.resize(size_t{4} * out.width * out.height);
  bccsplat_frame* f = nullptr;
  api(bccsplat_frame_wrap(device_, out.width, out.height, out.rgba.data(), 0, &f));
  const Handle<bccsplat_frame> frame(f);
  api(bccsplat_renderer_render(r, f));
#ifdef BCCSPLAT_BENCH_READERS
  if (shot.mode == BCCSPLAT_MODE_XRAY) {
    std::optional<bcc4::XrayExposure> exposure;
    bcc4::expose_xray(f, camera, info_of(slice.get()), bcc4::least_background(look(), 0), true, exposure);
  }
#endif
  return out;
}

bccsplat_look PictureVolume::look() const {
  auto made = sized<bccsplat_look>();
  api(bccsplat_volume_get_look(volume_.get(), 0, BCCSPLAT_LOOK_DEFAULT, BCCSPLAT_MODE_COMPOSITE, &made));
  return made;
}

std::vector<float> PictureVolume::field(const std::vector<std::array<double, 4>>& points) const {
  std::vector<float> values(points.size());
  api(bccsplat_volume_evaluate(volume_.get(), points.size(), points.data()->data(), values.data(), nullptr));
  return values;
}

} // namespace bccsplat::bench
