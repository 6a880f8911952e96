// SPDX-License-Identifier: Apache-2.0
// Frames hold pixels of their own or wrap the host's. What is written into files is gathered here from frame
// and options (camera, rate, exposure); the files are written by formats/image.
#include <algorithm>
#include <cmath>
#include <limits>

#include "api/handles.h"
#include "api/structs.h"
#include "base/sizes.h"
#include "formats/image/exr.h"
#include "formats/image/png.h"

using namespace bccsplat;
using namespace bccsplat::api;

namespace {

constexpr uint32_t all_channels = BCCSPLAT_FRAME_RGBA | BCCSPLAT_FRAME_DEPTH | BCCSPLAT_FRAME_VALUE |
                                  BCCSPLAT_FRAME_TIME | BCCSPLAT_FRAME_DEEP;

void check_size(uint32_t width, uint32_t height) {
  if (width < 1 || width > 65536 || height < 1 || height > 65536)
    fail(Code::invalid_argument, "frame: ", width, " x ", height, " is not in 1 .. 65536");
}

const Plane* plane_of(const bccsplat_frame& frame, uint32_t channel) {
  switch (channel) {
  case BCCSPLAT_FRAME_RGBA:
    return &frame.image.rgba;
  case BCCSPLAT_FRAME_DEPTH:
    return &frame.image.depth;
  case BCCSPLAT_FRAME_VALUE:
    return &frame.image.value;
  case BCCSPLAT_FRAME_TIME:
    return &frame.image.time;
  default:
    return nullptr;
  }
}

ExrView view_of(const WorldCamera& camera, const Image& image) {
  const PictureMatrices m = picture_matrices(camera, image.width, image.height);
  return {m.world_to_camera, m.world_to_ndc,
          camera.perspective ? camera.height * image.width / image.height : 1};
}

void check_sequence(const bccsplat_image_options& o) {
  const auto [numerator, denominator] = o.frames_per_second;
  if (!(numerator > 0 && denominator > 0) && !(numerator == 0 && denominator == 0))
    fail(Code::invalid_argument, "image options: frames_per_second ", numerator, " / ", denominator,
         " must be positive, or both 0");
  if (!(o.exposure_seconds >= 0 && std::isfinite(o.exposure_seconds)))
    fail(Code::invalid_argument, "image options: exposure_seconds ", o.exposure_seconds,
         " must be finite and not negative");
}

ExrOptions exr_options(const bccsplat_frame& frame, const bccsplat_image_options* options) {
  const auto o = read_struct(options, "bccsplat_image_options");
  require_zero(o.reserved, "bccsplat_image_options.reserved");
  check_sequence(o);
  ExrOptions exr;
  exr.overwrite = o.overwrite != 0;
  exr.attributes = frame.attributes;
  exr.frames_per_second = {o.frames_per_second[0], o.frames_per_second[1]};
  exr.exposure_seconds = o.exposure_seconds;
  if (o.comments) exr.comments = o.comments;
  if (frame.camera) exr.view = view_of(*frame.camera, frame.image);
  return exr;
}

const DeepImage& deep_of(const bccsplat_frame& frame) {
  if (!frame.image.deep) fail(Code::not_found, "frame: it was made without BCCSPLAT_FRAME_DEEP");
  if (frame.deep.first.empty()) fail(Code::wrong_state, "frame: nothing was rendered into it yet");
  return frame.deep;
}

} // namespace

extern "C" {

bccsplat_status bccsplat_frame_create(bccsplat_device* device, uint32_t width, uint32_t height,
                                      uint32_t channels, bccsplat_frame** frame) {
  return guard([&] {
    require(frame, "frame");
    *frame = nullptr;
    require(device, "device");
    check_size(width, height);
    if (channels & ~all_channels)
      fail(Code::invalid_argument, "frame: unknown channel bits ", channels & ~all_channels);
    auto f = std::make_unique<bccsplat_frame>();
    f->device = Ref(device);
    f->image.width = static_cast<int>(width), f->image.height = static_cast<int>(height);
    size_t floats = 4;
    for (const uint32_t bit : {BCCSPLAT_FRAME_DEPTH, BCCSPLAT_FRAME_VALUE, BCCSPLAT_FRAME_TIME})
      if (channels & bit) ++floats;
    const size_t pixels = size_t{width} * height;
    f->memory = Reservation(device->memory, checked_product({pixels, floats, sizeof(float)}), "frame");
    f->storage.resize(pixels * floats);
    float* next = f->storage.data();
    const auto take = [&](Plane& plane, int components) {
      plane = {next, size_t{width} * static_cast<size_t>(components), components};
      next += pixels * static_cast<size_t>(components);
    };
    take(f->image.rgba, 4);
    if (channels & BCCSPLAT_FRAME_DEPTH) take(f->image.depth, 1);
    if (channels & BCCSPLAT_FRAME_VALUE) take(f->image.value, 1);
    if (channels & BCCSPLAT_FRAME_TIME) take(f->image.time, 1);
    if (channels & BCCSPLAT_FRAME_DEEP) f->image.deep = &f->deep;
    *frame = f.release();
  });
}

bccsplat_status bccsplat_frame_wrap(bccsplat_device* device, uint32_t width, uint32_t height, float* rgba,
                                    uint64_t row_bytes, bccsplat_frame** frame) {
  return guard([&] {
    require(frame, "frame");
    *frame = nullptr;
    require(device, "device"), require(rgba, "rgba");
    check_size(width, height);
    const uint64_t row = row_bytes ? row_bytes : uint64_t{width} * 16;
    if (row % sizeof(float) != 0 || row < uint64_t{width} * 16)
      fail(Code::invalid_argument, "frame: row_bytes ", row, " must be a multiple of 4 and hold ", width,
           " pixels of 16 bytes");
    if (reinterpret_cast<uintptr_t>(rgba) % alignof(float) != 0)
      fail(Code::invalid_argument, "frame: rgba is not aligned to its floats");
    auto f = std::make_unique<bccsplat_frame>();
    f->device = Ref(device);
    f->image.width = static_cast<int>(width), f->image.height = static_cast<int>(height);
    f->image.rgba = {rgba, row / sizeof(float), 4};
    *frame = f.release();
  });
}

void bccsplat_frame_retain(bccsplat_frame* frame) { retain(frame); }
void bccsplat_frame_release(bccsplat_frame* frame) { release(frame); }

bccsplat_status bccsplat_frame_get_channel(const bccsplat_frame* frame, uint32_t channel,
                                           bccsplat_plane* plane) {
  return guard([&] {
    require(frame, "frame");
    const Plane* p = plane_of(*frame, channel);
    if (!p) fail(Code::invalid_argument, "frame: ", channel, " is not one channel bit");
    if (!p->pixels) fail(Code::not_found, "frame: it was made without channel ", channel);
    bccsplat_plane out{};
    out.components = static_cast<uint32_t>(p->components);
    out.width = static_cast<uint32_t>(frame->image.width),
    out.height = static_cast<uint32_t>(frame->image.height);
    out.pixels = p->pixels;
    out.row_bytes = p->row_floats * sizeof(float);
    write_struct(plane, out, "plane");
  });
}

bccsplat_status bccsplat_frame_save_exr(const bccsplat_frame* frame, const char* path,
                                        const bccsplat_image_options* options) {
  return guard([&] {
    require(frame, "frame"), require(path, "path");
    const ExrOptions exr = exr_options(*frame, options);
    const Image& image = frame->image;
    std::vector<ExrChannel> channels;
    for (size_t c = 0; c < 4; ++c)
      channels.push_back({std::string(1, "RGBA"[c]), image.rgba.pixels + c, 4, image.rgba.row_floats});
    const auto add = [&](const char* name, const Plane& plane) {
      if (plane.pixels) channels.push_back({name, plane.pixels, 1, plane.row_floats});
    };
    add("depth.Z", image.depth), add("value.Y", image.value), add("time.Y", image.time);
    write_exr(path, image.width, image.height, channels, exr);
  });
}

bccsplat_status bccsplat_frame_get_deep(const bccsplat_frame* frame, bccsplat_deep* deep) {
  return guard([&] {
    require(frame, "frame");
    const DeepImage& image = deep_of(*frame);
    bccsplat_deep out{};
    out.components = DeepImage::components;
    out.width = static_cast<uint32_t>(frame->image.width),
    out.height = static_cast<uint32_t>(frame->image.height);
    out.sample_count = image.first.back();
    out.first = image.first.data(), out.samples = image.samples.data();
    write_struct(deep, out, "deep");
  });
}

bccsplat_status bccsplat_frame_save_deep_exr(const bccsplat_frame* frame, const char* path,
                                             const bccsplat_image_options* options) {
  return guard([&] {
    require(frame, "frame"), require(path, "path");
    const ExrOptions exr = exr_options(*frame, options);
    const DeepImage& image = deep_of(*frame);
    write_deep_exr(path, frame->image.width, frame->image.height, image.first, image.samples, exr);
  });
}

bccsplat_status bccsplat_frame_save_png(const bccsplat_frame* frame, const char* path,
                                        const bccsplat_image_options* options) {
  return guard([&] {
    require(frame, "frame"), require(path, "path");
    const auto o = read_struct(options, "bccsplat_image_options");
    require_zero(o.reserved, "bccsplat_image_options.reserved");
    PngOptions png;
    png.overwrite = o.overwrite != 0;
    if (o.use_background) png.background = {o.background[0], o.background[1], o.background[2]};
    write_png(path, frame->image.width, frame->image.height, frame->image.rgba.pixels,
              frame->image.rgba.row_floats, png);
  });
}

} // extern "C"
