// SPDX-License-Identifier: Apache-2.0
#include "tool/view/camera_choice.h"

#include "readers/text.h"
#include "tool/cli.h"

namespace bcc4 {
namespace {

// The pixels of a picture.
std::array<uint32_t, 2> picture_size(const RenderArguments& a, const HostThings& host,
                                     const std::array<uint32_t, 2>& otherwise) {
  if (host.over) {
    const std::array<uint32_t, 2> size{host.over->width, host.over->height};
    if (a.size && *a.size != size)
      fail_usage("--size: ", a.over, " has ", size[0], " x ", size[1], " pixels, and so has the picture");
    return size;
  }
  return a.size.value_or(host.resolution.value_or(otherwise));
}

} // namespace

HostThings host_things(const RenderArguments& a) {
  HostThings host;
  host.clips = a.clips;
  if (host.clips.size() > BCCSPLAT_MAX_CLIPS)
    fail_usage("--clip and --box make ", host.clips.size(), " half-spaces, a box six; at most ",
               int{BCCSPLAT_MAX_CLIPS});
  if (!a.view_matrix.empty()) {
    if (a.camera != "ortho" || a.view || a.rotate_x || a.rotate_y || a.fit_domain || a.zoom || a.turntable)
      fail_usage("--view-matrix is the view: --camera, --view, --rotate-x, --rotate-y, --fit, --zoom and "
                 "--turntable "
                 "do not change it");
    if (a.annotate || !a.title.empty())
      fail_usage("--annotate draws scales and axes by a camera, which --view-matrix does not tell");
    if (a.mode == BCCSPLAT_MODE_XRAY && !lower(a.output).ends_with(".exr"))
      fail_usage("--view-matrix: an X-ray is exposed by a camera; write it as .exr");
    read_view_matrices(a.view_matrix, host);
  }
  if (!a.over.empty()) host.over = read_host_picture(a.over);
  return host;
}

CameraChoice choose_camera(const RenderArguments& a, const HostThings& host) {
  CameraChoice choice;
  if (lower(a.camera).ends_with(".json")) {
    choice.file = read_camera_file(a.camera);
    if (choice.file->resolution) choice.size = *choice.file->resolution;
    if (a.rotate_x || a.rotate_y || a.view || a.fit_domain)
      fail_usage("--view, --rotate-x, --rotate-y and --fit do not change a camera read from a file");
  } else {
    choice.projection = option_choice<int32_t>(
        "--camera", a.camera,
        {{"ortho", BCCSPLAT_PROJECTION_ORTHOGRAPHIC}, {"persp", BCCSPLAT_PROJECTION_PERSPECTIVE}});
  }
  choice.size = picture_size(a, host, choice.size);
  return choice;
}

} // namespace bcc4
