// SPDX-License-Identifier: Apache-2.0
#include "scene/save_picture.h"

#include "formats/image/exr.h"
#include "formats/image/png.h"

namespace bccsplat {
namespace {

ExrView view_of(const WorldCamera& camera, const Image& image) {
  const PictureMatrices m = picture_matrices(camera, image.width, image.height);
  return {m.world_to_camera, m.world_to_ndc,
          camera.perspective ? camera.height * image.width / image.height : 1};
}

std::vector<ExrChannel> exr_channels(const Image& image) {
  std::vector<ExrChannel> channels;
  for (size_t c = 0; c < 4; ++c)
    channels.push_back({std::string(1, "RGBA"[c]), image.rgba.pixels + c, 4, image.rgba.row_floats});
  const auto add = [&](const char* name, const Plane& plane) {
    if (plane.pixels) channels.push_back({name, plane.pixels, 1, plane.row_floats});
  };
  add("depth.Z", image.depth), add("value.Y", image.value), add("time.Y", image.time);
  return channels;
}

ExrOptions exr_options(const Image& image, const PictureNotes& notes, Progress& progress) {
  ExrOptions exr;
  exr.progress = &progress;
  exr.attributes = notes.attributes;
  exr.frames_per_second = notes.frames_per_second;
  exr.exposure_seconds = notes.exposure_seconds;
  exr.comments = notes.comments;
  if (notes.camera) exr.view = view_of(*notes.camera, image);
  return exr;
}

} // namespace

void save_picture(ByteSink& sink, const std::string& name, PictureFormat format, const Image& image,
                  const DeepImage* deep, const PictureNotes& notes, Progress& progress) {
  if (format == PictureFormat::png)
    write_png(sink, name, image.width, image.height, image.rgba.pixels, image.rgba.row_floats,
              {.progress = &progress, .background = notes.background});
  else if (format == PictureFormat::exr)
    write_exr(sink, name, image.width, image.height, exr_channels(image),
              exr_options(image, notes, progress));
  else
    write_deep_exr(sink, name, image.width, image.height, deep->first, deep->samples,
                   exr_options(image, notes, progress));
}

} // namespace bccsplat
