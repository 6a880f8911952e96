// SPDX-License-Identifier: Apache-2.0
// Frames hold pixels of their own or wrap the host's. What is written into files is gathered here from frame
// and options (camera, rate, exposure).
#include <algorithm>
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
    auto f = std::make_unique<bccsplat_frame>();
    f->device = Ref(device);
    f->image.width = width, f->image.height = height;
    size_t floats = 4;
    for (const uint32_t bit : {BCCSPLAT_FRAME_DEPTH, BCCSPLAT_FRAME_VALUE, BCCSPLAT_FRAME_TIME})
      if (channels & bit) ++floats;
    const size_t pixels = size_t{width} * height;
    f->memory = Reservation(device->memory, checked_product({pixels, floats, sizeof(float)}), "frame");
    f->storage.resize(pixels * floats);
    float* next = f->storage.data();
    const auto take = [&](Plane& plane, int components) {
      plane = {next, size_t{width} * components, components};
      next += pixels * components;
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
    require_pixels(width, height, "frame");
    const uint64_t row = row_bytes ? row_bytes : uint64_t{width} * 16;
    if (row % sizeof(float) != 0 || row < uint64_t{width} * 16)
      fail(Code::invalid_argument, "frame: row_bytes ", row, " must be a multiple of 4 and hold ", width,
           " pixels of 16 bytes");
    if (row > memory_end / height || row * height > UINTPTR_MAX - reinterpret_cast<uintptr_t>(rgba))
      fail(Code::invalid_argument, "frame: ", height, " rows of row_bytes ", row,
           " are more than memory holds");
    if (reinterpret_cast<uintptr_t>(rgba) % alignof(float) != 0)
      fail(Code::invalid_argument, "frame: rgba is not aligned to its floats");
    auto f = std::make_unique<bccsplat_frame>();
    f->device = Ref(device);
    f->image.width = width, f->image.height = height;
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
    const Plane& p = required_plane(*frame, channel);
    bccsplat_plane out{};
    out.components = p.components;
    out.width = frame->image.width, out.height = frame->image.height;
    out.pixels = p.pixels;
    out.row_bytes = p.row_floats * sizeof(float);
    write_struct(plane, out, "plane");
  });
}

bccsplat_status bccsplat_frame_copy(const bccsplat_frame* frame, uint32_t channel,
                                    bccsplat_pixel_format format, void* pixels, int64_t row_bytes) {
  return guard([&] {
    require(frame, "frame"), require(pixels, "pixels");
    const Plane& plane = required_plane(*frame, channel);
    if (format < BCCSPLAT_PIXELS_F32 || format > BCCSPLAT_PIXELS_SRGB8_PREMULTIPLIED)
      fail(Code::invalid_argument, "frame: unknown pixel format ", format);
    if (format >= BCCSPLAT_PIXELS_SRGB8 && plane.components != 4)
      fail(Code::invalid_argument, "frame: bytes are of BCCSPLAT_FRAME_RGBA alone");
    const auto as = static_cast<PixelFormat>(format);
    const auto number = static_cast<int64_t>(number_bytes(as));
    const int64_t packed = int64_t{frame->image.width} * plane.components * number;
    const int64_t row = row_bytes ? row_bytes : packed;
    if (row > -packed && row < packed)
      fail(Code::invalid_argument, "frame: row_bytes ", row, " does not hold ", frame->image.width,
           " pixels of ", plane.components * number, " bytes");
    if (row % number != 0 || reinterpret_cast<uintptr_t>(pixels) % static_cast<uintptr_t>(number) != 0)
      fail(Code::invalid_argument, "frame: pixels and row_bytes must be multiples of ", number);
    const auto most = static_cast<int64_t>(memory_end / static_cast<uint64_t>(frame->image.height));
    if (row > most || row < -most)
      fail(Code::invalid_argument, "frame: row_bytes ", row, " is more than memory holds");
    copy_pixels(plane, frame->image.width, frame->image.height, as, static_cast<std::byte*>(pixels),
                static_cast<std::ptrdiff_t>(row), *frame->device->tasks);
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
