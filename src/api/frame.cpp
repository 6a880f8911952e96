// SPDX-License-Identifier: Apache-2.0
// Frames hold pixels of their own or wrap the host's. What is written into files is gathered here from frame
// and options (camera, rate, exposure).
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "api/handles.h"
#include "api/numbers.h"
#include "api/streams.h"
#include "api/structs.h"
#include "api/texts.h"
#include "base/sizes.h"
#include "scene/copy_pixels.h"
#include "scene/save_picture.h"

using namespace bccsplat;
using namespace bccsplat::api;

namespace {

constexpr uint32_t all_channels = BCCSPLAT_FRAME_RGBA | BCCSPLAT_FRAME_DEPTH | BCCSPLAT_FRAME_VALUE |
                                  BCCSPLAT_FRAME_TIME | BCCSPLAT_FRAME_DEEP;

// Null: no bit of a plane.
template<class Frame> auto* plane_of(Frame& frame, uint32_t channel) {
  auto& image = frame.image;
  switch (channel) {
  case BCCSPLAT_FRAME_RGBA:
    return &image.rgba;
  case BCCSPLAT_FRAME_DEPTH:
    return &image.depth;
  case BCCSPLAT_FRAME_VALUE:
    return &image.value;
  case BCCSPLAT_FRAME_TIME:
    return &image.time;
  default:
    return static_cast<decltype(&image.rgba)>(nullptr);
  }
}

int components_of(uint32_t channel) { return channel == BCCSPLAT_FRAME_RGBA ? 4 : 1; }

// A frame with planes, and deep samples, of its own.
std::unique_ptr<bccsplat_frame> make_frame(bccsplat_device* device, uint32_t width, uint32_t height,
                                           uint32_t channels) {
  constexpr std::array<uint32_t, 4> planes{BCCSPLAT_FRAME_RGBA, BCCSPLAT_FRAME_DEPTH, BCCSPLAT_FRAME_VALUE,
                                           BCCSPLAT_FRAME_TIME};
  auto f = std::make_unique<bccsplat_frame>();
  f->device = Ref(device);
  f->image.width = static_cast<int>(width), f->image.height = static_cast<int>(height);
  size_t floats = 0;
  for (const uint32_t bit : planes) floats += channels & bit ? static_cast<size_t>(components_of(bit)) : 0;
  const size_t pixels = size_t{width} * height;
  f->memory = Reservation(device->memory, checked_product({pixels, floats, sizeof(float)}), "frame");
  f->storage.resize(pixels * floats);
  float* next = f->storage.data();
  for (const uint32_t bit : planes) {
    if (!(channels & bit)) continue;
    const int components = components_of(bit);
    *plane_of(*f, bit) = {next, static_cast<std::ptrdiff_t>(width) * components, components};
    next += pixels * static_cast<size_t>(components);
  }
  if (channels & BCCSPLAT_FRAME_DEEP) f->image.deep = &f->deep;
  return f;
}

// Rows of the host's, row_bytes apart (not 0), are rows of floats in memory that do not overlap.
void check_rows(const float* pixels, int64_t row_bytes, uint32_t width, uint32_t height, int components,
                const std::string& name) {
  const uint64_t least = uint64_t{width} * static_cast<uint64_t>(components) * sizeof(float);
  const uint64_t row =
      row_bytes < 0 ? 0 - static_cast<uint64_t>(row_bytes) : static_cast<uint64_t>(row_bytes);
  if (row % sizeof(float) != 0 || row < least)
    fail(Code::invalid_argument, name, ": row_bytes ", row_bytes, " must be a multiple of 4 and hold ", width,
         " pixels of ", static_cast<size_t>(components) * sizeof(float), " bytes");
  const auto address = reinterpret_cast<uintptr_t>(pixels);
  const uint64_t room = row_bytes < 0 ? address : UINTPTR_MAX - address;
  if (row > memory_end / height || row * height > room)
    fail(Code::invalid_argument, name, ": ", height, " rows of row_bytes ", row_bytes,
         " are more than memory holds");
  if (address % alignof(float) != 0) fail(Code::invalid_argument, name, ": it is not aligned to its floats");
}

int64_t row_bytes_of(const bccsplat_host_plane& plane, uint32_t width) {
  if (plane.row_bytes != 0) return plane.row_bytes;
  return int64_t{width} * components_of(plane.channel) * static_cast<int64_t>(sizeof(float));
}

void check_host_plane(const bccsplat_host_plane& plane, uint64_t n, uint32_t width, uint32_t height) {
  const std::string name = concat("planes[", n, "]");
  require_zero(plane.reserved, "bccsplat_host_plane.reserved");
  if (plane.channel == 0 || (plane.channel & ~all_channels) != 0 || !std::has_single_bit(plane.channel))
    fail(Code::invalid_argument, name, ": ", plane.channel, " is not one channel bit");
  if (!plane.pixels) return;
  if (plane.channel == BCCSPLAT_FRAME_DEEP)
    fail(Code::invalid_argument, name, ": BCCSPLAT_FRAME_DEEP has no pixels; leave them NULL");
  check_rows(plane.pixels, row_bytes_of(plane, width), width, height, components_of(plane.channel), name);
}

Plane plane_there(const bccsplat_host_plane& plane, uint32_t width) {
  constexpr auto bytes = static_cast<int64_t>(sizeof(float));
  return {plane.pixels, static_cast<std::ptrdiff_t>(row_bytes_of(plane, width) / bytes),
          components_of(plane.channel)};
}

void check_sequence(const bccsplat_image_options& o) {
  const auto [numerator, denominator] = o.frames_per_second;
  if (!(numerator > 0 && denominator > 0) && !(numerator == 0 && denominator == 0))
    fail(Code::invalid_argument, "image options: frames_per_second ", numerator, " / ", denominator,
         " must be positive, or both 0");
  require_range(o.exposure_seconds, 0, largest_number, "bccsplat_image_options.exposure_seconds");
  require_utf8(o.comments, "bccsplat_image_options.comments");
}

const Plane& required_plane(const bccsplat_frame& frame, uint32_t channel) {
  if (channel == BCCSPLAT_FRAME_DEEP)
    fail(Code::invalid_argument, "frame: BCCSPLAT_FRAME_DEEP has no plane; see bccsplat_frame_get_deep");
  const Plane* p = plane_of(frame, channel);
  if (!p) fail(Code::invalid_argument, "frame: ", channel, " is not one channel bit");
  if (!p->pixels) fail(Code::not_found, "frame: it was made without channel ", channel);
  return *p;
}

const DeepImage& deep_of(const bccsplat_frame& frame) {
  if (!frame.image.deep) fail(Code::not_found, "frame: it was made without BCCSPLAT_FRAME_DEEP");
  if (frame.deep.first.empty())
    fail(Code::wrong_state,
         "frame: it has no samples: nothing was rendered into it yet, or the last render was "
         "cancelled or failed");
  return frame.deep;
}

// Writes what a file would hold into a sink, made once nothing is refused any more, and commits it. name: for
// error texts.
template<class MakeSink>
void save(const bccsplat_frame& frame, int32_t format, const bccsplat_image_options* options,
          const std::string& name, const MakeSink& make_sink) {
  if (frame.gl) fail(Code::unsupported, "frame: its pixels are in the host's texture; read them there");
  const auto o = read_struct(options, "bccsplat_image_options");
  require_zero(o.reserved, "bccsplat_image_options.reserved");
  require_range(o.background, 0, largest_colour, "bccsplat_image_options.background");
  const Token token = read_token(o.cancel_token);
  Progress progress(progress_callback(o.progress, o.progress_user));
  watch(progress, token);
  progress.throw_if_cancelled();
  PictureFormat as = PictureFormat::png;
  if (format == BCCSPLAT_IMAGE_EXR)
    as = PictureFormat::exr;
  else if (format == BCCSPLAT_IMAGE_DEEP_EXR)
    as = PictureFormat::deep_exr;
  else if (format != BCCSPLAT_IMAGE_PNG)
    fail(Code::invalid_argument, "frame: ", format, " is no format of images");
  PictureNotes notes;
  if (o.use_background) notes.background = {o.background[0], o.background[1], o.background[2]};
  if (as != PictureFormat::png) {
    check_sequence(o);
    notes.frames_per_second = {o.frames_per_second[0], o.frames_per_second[1]};
    notes.exposure_seconds = o.exposure_seconds;
    if (o.comments) notes.comments = o.comments;
    notes.camera = frame.camera, notes.attributes = frame.attributes;
  }
  const DeepImage* const deep = as == PictureFormat::deep_exr ? &deep_of(frame) : nullptr;
  const std::unique_ptr<ByteSink> sink = make_sink(o);
  save_picture(*sink, name, as, frame.image, deep, notes, progress);
  progress.report(1); // the last chance to cancel
  sink->commit();
}

bccsplat_status save_file(const bccsplat_frame* frame, int32_t format, const char* path,
                          const bccsplat_image_options* options) {
  return guard([&] {
    require(frame, "frame"), require(path, "path");
    save(*frame, format, options, path,
         [&](const bccsplat_image_options& o) { return create_file_sink(path, o.overwrite != 0); });
  });
}

// Checks where pixels are to be copied; returns the bytes from one row to the next.
std::ptrdiff_t check_copy(const Plane& plane, int width, int height, bccsplat_pixel_format format,
                          const void* pixels, int64_t row_bytes) {
  if (format < BCCSPLAT_PIXELS_F32 || format > BCCSPLAT_PIXELS_SRGB8_PREMULTIPLIED)
    fail(Code::invalid_argument, "frame: unknown pixel format ", format);
  if (format >= BCCSPLAT_PIXELS_SRGB8 && plane.components != 4)
    fail(Code::invalid_argument, "frame: bytes are of BCCSPLAT_FRAME_RGBA alone");
  const auto number = static_cast<int64_t>(number_bytes(static_cast<PixelFormat>(format)));
  const int64_t packed = int64_t{width} * plane.components * number;
  const int64_t row = row_bytes ? row_bytes : packed;
  if (row > -packed && row < packed)
    fail(Code::invalid_argument, "frame: row_bytes ", row, " does not hold ", width, " pixels of ",
         plane.components * number, " bytes");
  if (row % number != 0 || reinterpret_cast<uintptr_t>(pixels) % static_cast<uintptr_t>(number) != 0)
    fail(Code::invalid_argument, "frame: pixels and row_bytes must be multiples of ", number);
  const auto most = static_cast<int64_t>(memory_end / static_cast<uint64_t>(height));
  if (row > most || row < -most)
    fail(Code::invalid_argument, "frame: row_bytes ", row, " is more than memory holds");
  return static_cast<std::ptrdiff_t>(row);
}

} // namespace

extern "C" {

bccsplat_status bccsplat_frame_create(bccsplat_device* device, uint32_t width, uint32_t height,
                                      uint32_t channels, bccsplat_frame** frame) {
  return guard([&] {
    require(frame, "frame");
    *frame = nullptr;
    require(device, "device");
    require_pixels(width, height, "frame");
    if (channels & ~all_channels)
      fail(Code::invalid_argument, "frame: unknown channel bits ", channels & ~all_channels);
    *frame = make_frame(device, width, height, channels | BCCSPLAT_FRAME_RGBA).release();
  });
}

bccsplat_status bccsplat_frame_wrap(bccsplat_device* device, uint32_t width, uint32_t height, float* rgba,
                                    uint64_t row_bytes, bccsplat_frame** frame) {
  return guard([&] {
    require(frame, "frame");
    *frame = nullptr;
    require(device, "device"), require(rgba, "rgba");
    require_pixels(width, height, "frame");
    if (row_bytes > INT64_MAX)
      fail(Code::invalid_argument, "frame: row_bytes ", row_bytes, " is more than memory holds");
    const bccsplat_host_plane plane{BCCSPLAT_FRAME_RGBA, 0, rgba, static_cast<int64_t>(row_bytes)};
    check_rows(rgba, row_bytes_of(plane, width), width, height, 4, "frame");
    std::unique_ptr<bccsplat_frame> f = make_frame(device, width, height, 0);
    f->image.rgba = plane_there(plane, width);
    *frame = f.release();
  });
}

bccsplat_status bccsplat_frame_wrap_planes(bccsplat_device* device, uint32_t width, uint32_t height,
                                           const bccsplat_host_plane* planes, uint64_t count,
                                           bccsplat_frame** frame) {
  return guard([&] {
    require(frame, "frame");
    *frame = nullptr;
    require(device, "device");
    require_pixels(width, height, "frame");
    if (count > 0) require(planes, "planes");
    uint32_t channels = 0, own = BCCSPLAT_FRAME_RGBA;
    for (uint64_t n = 0; n < count; ++n) {
      check_host_plane(planes[n], n, width, height);
      if (channels & planes[n].channel)
        fail(Code::invalid_argument, "frame: channel ", planes[n].channel, " is given twice");
      channels |= planes[n].channel;
      if (planes[n].pixels)
        own &= ~planes[n].channel;
      else
        own |= planes[n].channel;
    }
    std::unique_ptr<bccsplat_frame> f = make_frame(device, width, height, own);
    for (uint64_t n = 0; n < count; ++n)
      if (planes[n].pixels) *plane_of(*f, planes[n].channel) = plane_there(planes[n], width);
    *frame = f.release();
  });
}

bccsplat_status bccsplat_frame_wrap_gl(bccsplat_device* device, const bccsplat_gl_target* target,
                                       bccsplat_frame** frame) {
  return guard([&] {
    require(frame, "frame");
    *frame = nullptr;
    require(device, "device"), require(target, "target");
    const auto in = read_struct(target, "bccsplat_gl_target");
    require_pixels(in.width, in.height, "frame");
    require_range(in.replace, 0, 1, "bccsplat_gl_target.replace");
    if (in.texture == 0) fail(Code::invalid_argument, "bccsplat_gl_target.texture is no texture");
    auto f = std::make_unique<bccsplat_frame>();
    f->device = Ref(device);
    f->image.width = static_cast<int>(in.width), f->image.height = static_cast<int>(in.height);
    f->gl = make_gpu({.host_context = true, .software_too = true, .memory_limit = device->gpu_memory});
    if (!f->gl) (void)gpu_info(nullptr); // says so
    f->gl_drawers = std::make_unique<Drawers>();
    f->target.texture = in.texture, f->target.depth_texture = in.depth_texture;
    f->target.replace = in.replace != 0;
    *frame = f.release();
  });
}

void bccsplat_frame_retain(bccsplat_frame* frame) { retain(frame); }
void bccsplat_frame_release(bccsplat_frame* frame) { release(frame); }

bccsplat_status bccsplat_frame_get_channel(const bccsplat_frame* frame, uint32_t channel,
                                           bccsplat_plane* plane) {
  return guard([&] {
    require(frame, "frame");
    const Plane& p = required_plane(*frame, channel);
    bccsplat_plane out{};
    out.components = p.components;
    out.width = frame->image.width, out.height = frame->image.height;
    out.pixels = p.pixels;
    out.row_bytes = static_cast<uint64_t>(p.row_floats) * sizeof(float);
    write_struct(plane, out, "plane");
  });
}

bccsplat_status bccsplat_frame_copy(const bccsplat_frame* frame, uint32_t channel,
                                    bccsplat_pixel_format format, void* pixels, int64_t row_bytes) {
  return guard([&] {
    require(frame, "frame"), require(pixels, "pixels");
    const Plane& plane = required_plane(*frame, channel);
    const auto [width, height] = std::pair(frame->image.width, frame->image.height);
    const std::ptrdiff_t row = check_copy(plane, width, height, format, pixels, row_bytes);
    copy_pixels(plane, width, height, static_cast<PixelFormat>(format), static_cast<std::byte*>(pixels), row,
                frame->device->tasks.get());
  });
}

bccsplat_status bccsplat_frame_copy_part(const bccsplat_frame* frame, uint32_t channel,
                                         bccsplat_pixel_format format, uint32_t x, uint32_t y, uint32_t width,
                                         uint32_t height, void* pixels, int64_t row_bytes) {
  return guard([&] {
    require(frame, "frame"), require(pixels, "pixels");
    Plane part = required_plane(*frame, channel);
    const auto inside = [](uint32_t begin, uint32_t count, int all) {
      return count > 0 && uint64_t{begin} + count <= static_cast<uint64_t>(all);
    };
    if (!inside(x, width, frame->image.width) || !inside(y, height, frame->image.height))
      fail(Code::invalid_argument, "frame: ", width, " x ", height, " pixels at (", x, ", ", y,
           ") are no part of ", frame->image.width, " x ", frame->image.height);
    const int w = static_cast<int>(width), h = static_cast<int>(height);
    part.pixels = part.at(static_cast<int>(x), static_cast<int>(y));
    const std::ptrdiff_t row = check_copy(part, w, h, format, pixels, row_bytes);
    copy_pixels(part, w, h, static_cast<PixelFormat>(format), static_cast<std::byte*>(pixels), row, nullptr);
  });
}

bccsplat_status bccsplat_frame_save_exr(const bccsplat_frame* frame, const char* path,
                                        const bccsplat_image_options* options) {
  return save_file(frame, BCCSPLAT_IMAGE_EXR, path, options);
}

bccsplat_status bccsplat_frame_get_deep(const bccsplat_frame* frame, bccsplat_deep* deep) {
  return guard([&] {
    require(frame, "frame");
    const DeepImage& image = deep_of(*frame);
    bccsplat_deep out{};
    out.components = DeepImage::components;
    out.width = frame->image.width, out.height = frame->image.height;
    out.sample_count = image.first.back();
    out.first = image.first.data(), out.samples = image.samples.data();
    write_struct(deep, out, "deep");
  });
}

bccsplat_status bccsplat_frame_save_deep_exr(const bccsplat_frame* frame, const char* path,
                                             const bccsplat_image_options* options) {
  return save_file(frame, BCCSPLAT_IMAGE_DEEP_EXR, path, options);
}

bccsplat_status bccsplat_frame_save_png(const bccsplat_frame* frame, const char* path,
                                        const bccsplat_image_options* options) {
  return save_file(frame, BCCSPLAT_IMAGE_PNG, path, options);
}

bccsplat_status bccsplat_frame_save_stream(const bccsplat_frame* frame, int32_t format,
                                           const bccsplat_write_stream* stream,
                                           const bccsplat_image_options* options) {
  return guard([&] {
    require(frame, "frame");
    std::unique_ptr<ByteSink> sink = sink_of(stream);
    save(*frame, format, options, "stream", [&](const auto&) { return std::move(sink); });
  });
}

bccsplat_status bccsplat_frame_save_memory(const bccsplat_frame* frame, int32_t format,
                                           const bccsplat_image_options* options, void* bytes,
                                           uint64_t capacity, uint64_t* size) {
  return guard([&] {
    require(frame, "frame");
    if (capacity > 0) require(bytes, "bytes");
    std::vector<std::byte> all;
    save(*frame, format, options, "memory", [&](const auto&) { return create_memory_sink(all); });
    std::copy_n(all.begin(), std::min<uint64_t>(capacity, all.size()), static_cast<std::byte*>(bytes));
    if (size) *size = all.size();
  });
}

} // extern "C"
